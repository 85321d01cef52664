//! The mutants of one file, as edits of its text.

use std::collections::HashSet;
use std::ops::Range;

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, BinOp, Block, Expr, GenericArgument, PathArguments, ReturnType, Signature, Type, UnOp};

/// A mutant.
pub struct Mutant {
    pub number: u32,
    pub line: usize,
    pub column: usize,
    pub function: String,
    pub what: String,
    /// The code on its line, with «» around what changes.
    pub code: String,
}

/// As many characters of a line are shown before what changes, and behind it.
const SHOWN: usize = 45;

/// Replaces a range of the text.
struct Edit {
    range: Range<usize>,
    text: String,
}

/// A file in the making.
pub struct Rewrite<'a> {
    source: &'a str,
    left_out: &'a HashSet<u32>,
    function: String,
    edits: Vec<Edit>,
    pub mutants: Vec<Mutant>,
    /// The number of the last mutant, with those that are left out.
    pub count: u32,
}

impl<'a> Rewrite<'a> {
    pub fn of(source: &'a str, file: &syn::File, count: u32, left_out: &'a HashSet<u32>) -> Self {
        let (function, edits, mutants) = (String::new(), Vec::new(), Vec::new());
        let mut rewrite = Self { source, left_out, function, edits, mutants, count };
        rewrite.visit_file(file);
        rewrite
    }

    /// The rewritten file.
    pub fn text(&self) -> String {
        edited(self.source, 0..self.source.len(), &self.edits)
    }

    /// The condition that switches a new mutant on; `None` if it is left out.
    fn mutant(&mut self, span: Span, what: String) -> Option<String> {
        self.count += 1;
        if self.left_out.contains(&self.count) {
            return None;
        }
        let (start, function) = (span.start(), self.function.clone());
        let (number, line, column) = (self.count, start.line, start.column + 1);
        let code = shown(self.source, span.byte_range());
        self.mutants.push(Mutant { number, line, column, function, what, code });
        Some(format!("crate::mutant::on({number})"))
    }

    fn replace(&mut self, range: Range<usize>, text: impl Into<String>) {
        self.edits.push(Edit { range, text: text.into() });
    }

    fn insert(&mut self, at: usize, text: impl Into<String>) {
        self.replace(at..at, text);
    }

    /// Operands are values of a `match`, so that each stands in the text once and temporaries live as long as before.
    fn binary(&mut self, it: &syn::ExprBinary, kind: Kind, [sign, other]: [&str; 2]) {
        let Some(on) = self.mutant(it.op.span(), format!("{sign} -> {other}")) else {
            return visit::visit_expr_binary(self, it);
        };
        let (whole, sides) = (it.span().byte_range(), [&it.left, &it.right].map(|side| side.span().byte_range()));
        if kind == Kind::Assignment {
            let first = self.edits.len();
            self.visit_expr(&it.left);
            let inner = self.edits.split_off(first);
            let place = edited(self.source, sides[0].clone(), &inner);
            self.replace(whole.start..sides[1].start, "(match (");
            self.visit_expr(&it.right);
            // A type may have no `/=`.
            let changed = format!("{place} = {place} {} r_", &other[..1]);
            let arm = format!("r_ => if {on} {{ {changed} }} else {{ {place} {sign} r_ }}");
            return self.insert(whole.end, format!(") {{ {arm} }})"));
        }
        let arm = format!("(l, r) => if {on} {{ l {other} r }} else {{ l {sign} r }}");
        let [before, between, after] = match kind {
            Kind::Comparison => ["(match (&(", "), &(", &format!(")) {{ {arm} }})")],
            Kind::Lazy => {
                let goes_on = if sign == "&&" { "!=" } else { "==" };
                ["(match (", &format!(") {{ l => if l {goes_on} {on} {{ "), " } else { l } })"]
            }
            _ => ["(match (", ", ", &format!(") {{ {arm} }})")],
        };
        self.insert(whole.start, before);
        self.visit_expr(&it.left);
        self.replace(it.op.span().byte_range(), between);
        self.visit_expr(&it.right);
        self.insert(whole.end, after);
    }

    fn unary(&mut self, it: &syn::ExprUnary, sign: &str) {
        let on = self.mutant(it.op.span(), format!("{sign} dropped"));
        if let Some(on) = &on {
            self.insert(it.span().byte_range().start, "(match (");
            self.replace(it.op.span().byte_range(), "");
            self.visit_expr(&it.expr);
            let arm = format!("v => if {on} {{ v }} else {{ {sign}v }}");
            self.insert(it.span().byte_range().end, format!(") {{ {arm} }})"));
        } else {
            self.visit_expr(&it.expr);
        }
    }

    /// A function: it may return at once.
    fn function(&mut self, attributes: &[Attribute], signature: &Signature, body: &Block) {
        if is_test(attributes) || signature.constness.is_some() {
            return;
        }
        let outer = std::mem::replace(&mut self.function, signature.ident.to_string());
        for value in values(&signature.output) {
            if body.stmts.is_empty() {
                break;
            }
            let what = format!("returns {}", if value.is_empty() { "at once" } else { value });
            if let Some(on) = self.mutant(signature.ident.span(), what) {
                self.insert(body.brace_token.span.open().byte_range().end, format!(" if {on} {{ return {value}; }}"));
            }
        }
        self.visit_block(body);
        self.function = outer;
    }
}

impl<'ast> Visit<'ast> for Rewrite<'_> {
    fn visit_expr(&mut self, it: &'ast Expr) {
        match it {
            Expr::Binary(it) => match counterpart(&it.op) {
                Some((Kind::Lazy, _)) if has_let(it) => visit::visit_expr_binary(self, it),
                Some((kind, signs)) => self.binary(it, kind, signs),
                None => visit::visit_expr_binary(self, it),
            },
            Expr::Unary(it) => match it.op {
                UnOp::Neg(_) => self.unary(it, "-"),
                UnOp::Not(_) => self.unary(it, "!"),
                _ => self.visit_expr(&it.expr),
            },
            Expr::Repeat(it) => self.visit_expr(&it.expr),
            Expr::Const(_) => {}
            _ => visit::visit_expr(self, it),
        }
    }

    fn visit_item(&mut self, it: &'ast syn::Item) {
        match it {
            syn::Item::Fn(it) => self.function(&it.attrs, &it.sig, &it.block),
            syn::Item::Mod(it) if is_test(&it.attrs) => {}
            syn::Item::Impl(it) if is_test(&it.attrs) => {}
            syn::Item::Mod(_) | syn::Item::Impl(_) | syn::Item::Trait(_) => visit::visit_item(self, it),
            _ => {}
        }
    }

    fn visit_impl_item(&mut self, it: &'ast syn::ImplItem) {
        if let syn::ImplItem::Fn(it) = it {
            self.function(&it.attrs, &it.sig, &it.block);
        }
    }

    fn visit_trait_item(&mut self, it: &'ast syn::TraitItem) {
        if let syn::TraitItem::Fn(it) = it
            && let Some(body) = &it.default
        {
            self.function(&it.attrs, &it.sig, body);
        }
    }

    // What follows must be constant, or has no value.
    fn visit_type(&mut self, _: &'ast Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_generics(&mut self, _: &'ast syn::Generics) {}
    fn visit_generic_argument(&mut self, _: &'ast GenericArgument) {}
    fn visit_attribute(&mut self, _: &'ast Attribute) {}
}

/// How the operands of an operator are used.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Value,
    Comparison,
    Lazy,
    Assignment,
}

/// The operator and the one that takes its place.
fn counterpart(operator: &BinOp) -> Option<(Kind, [&'static str; 2])> {
    Some(match operator {
        BinOp::Add(_) => (Kind::Value, ["+", "-"]),
        BinOp::Sub(_) => (Kind::Value, ["-", "+"]),
        BinOp::Mul(_) => (Kind::Value, ["*", "/"]),
        BinOp::Div(_) => (Kind::Value, ["/", "*"]),
        BinOp::Lt(_) => (Kind::Comparison, ["<", "<="]),
        BinOp::Le(_) => (Kind::Comparison, ["<=", "<"]),
        BinOp::Gt(_) => (Kind::Comparison, [">", ">="]),
        BinOp::Ge(_) => (Kind::Comparison, [">=", ">"]),
        BinOp::Eq(_) => (Kind::Comparison, ["==", "!="]),
        BinOp::Ne(_) => (Kind::Comparison, ["!=", "=="]),
        BinOp::And(_) => (Kind::Lazy, ["&&", "||"]),
        BinOp::Or(_) => (Kind::Lazy, ["||", "&&"]),
        BinOp::AddAssign(_) => (Kind::Assignment, ["+=", "-="]),
        BinOp::SubAssign(_) => (Kind::Assignment, ["-=", "+="]),
        BinOp::MulAssign(_) => (Kind::Assignment, ["*=", "/="]),
        BinOp::DivAssign(_) => (Kind::Assignment, ["/=", "*="]),
        _ => return None,
    })
}

/// What a function may return at once.
fn values(output: &ReturnType) -> &'static [&'static str] {
    let ReturnType::Type(_, output) = output else { return &[""] };
    let Type::Path(path) = &**output else { return &[] };
    let Some(last) = path.path.segments.last() else { return &[] };
    match last.ident.to_string().as_str() {
        "bool" => &["true", "false"],
        "usize" | "u32" | "u64" | "i32" => &["0", "1"],
        "f64" => &["0.0", "1.0"],
        "S" => &["S::ZERO", "S::ONE"],
        "Option" => &["None"],
        "Vec" => &["Vec::new()"],
        "Result" => match &last.arguments {
            PathArguments::AngleBracketed(of) => match of.args.first() {
                Some(GenericArgument::Type(Type::Tuple(tuple))) if tuple.elems.is_empty() => &["Ok(())"],
                _ => &[],
            },
            _ => &[],
        },
        _ => &[],
    }
}

/// Whether a chain of conditions binds names, so that it must stay a chain.
fn has_let(it: &syn::ExprBinary) -> bool {
    [&it.left, &it.right].into_iter().any(|side| match &**side {
        Expr::Let(_) => true,
        Expr::Binary(it) => matches!(it.op, BinOp::And(_)) && has_let(it),
        _ => false,
    })
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|it| match &it.meta {
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        _ => false,
    })
}

/// Some code around a part of the text, on the same line, with «» around that part.
fn shown(source: &str, part: Range<usize>) -> String {
    let before = source[..part.start].rsplit('\n').next().unwrap_or_default();
    let behind = source[part.end..].split('\n').next().unwrap_or_default();
    let skipped = before.chars().count().saturating_sub(SHOWN);
    let before: String = before.chars().skip(skipped).collect();
    let behind: String = behind.chars().take(SHOWN).collect();
    format!("{}«{}»{}", before.trim_start(), &source[part], behind.trim_end())
}

/// A part of the text after the edits. Edits at one place keep their order.
fn edited(source: &str, part: Range<usize>, edits: &[Edit]) -> String {
    let mut sorted: Vec<&Edit> = edits.iter().collect();
    sorted.sort_by_key(|edit| edit.range.start);
    let (mut text, mut at) = (String::new(), part.start);
    for edit in sorted {
        text.push_str(&source[at..edit.range.start]);
        text.push_str(&edit.text);
        at = edit.range.end;
    }
    text.push_str(&source[at..part.end]);
    text
}
