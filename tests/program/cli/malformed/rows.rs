//! What is wrong, and what must be said about it.

pub(super) const HORIZON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/hard/horizon.toml");

/// A valid case. The tables below name its lines and columns.
pub(super) const QUARTIC: &str = r#"title = "Quartic"

[potential]
quartic = { kappa = 0.5 }

[particle]
mass = 1.0
c = 1.0

[initial]
t = 0.0
x = 1.0
x_dot = 0.1
t_dot = 1.0

[grid]
gamma_f = 1.0
n_gamma = 32

[scheme]
sbp = "SBP21"

[solver]
max_iterations = 50
"#;

pub(super) const POTENTIAL: &str = "quartic = { kappa = 0.5 }";
pub(super) const START_AND_END: &str = "t_dot = 1.0\n\n[grid]\ngamma_f = 1.0";
pub(super) const INITIAL: &str = "[initial]\nt = 0.0\nx = 1.0\nx_dot = 0.1\nt_dot = 1.0\n";
pub(super) const SOLVER: &str = "max_iterations = 50";

/// (name, what of `QUARTIC` is replaced, by what, line:column of the mistake, what the message contains); exit code 2.
pub(super) const EDITS: &[(&str, &str, &str, &str, &str)] = &[
    // Keys
    ("unknown key at the top", "title", "tilte", "1:1", "unknown field `tilte`, expected one of `title`"),
    ("unknown table", "[solver]", "[solvers]", "23:2", "unknown field `solvers`"),
    ("unknown key in a table", "n_gamma", "steps", "18:1", "unknown field `steps`, expected one of `gamma_i`"),
    ("unknown key in the solver", "max_iterations", "max_iter", "24:1", "unknown field `max_iter`"),
    ("unknown potential", "quartic =", "cubic =", "4:1", "unknown variant `cubic`, expected one of `free`, `linear`"),
    ("unknown key of a potential", "kappa = 0.5", "kappa = 0.5, mu = 1.0", "4:26", "mu, available keys: kappa"),
    ("quoted key with a blank", "x = 1.0", "\"x \" = 1.0", "12:1", "unknown field `x `"),
    ("empty key", "x = 1.0", "\"\" = 1.0", "12:1", "unknown field ``"),
    ("missing x", "x = 1.0\n", "", "10:1", "missing field `x`"),
    ("missing n_gamma", "n_gamma = 32\n", "", "16:1", "missing field `n_gamma`"),
    ("missing sbp", "sbp = \"SBP21\"\n", "", "20:1", "missing field `sbp`"),
    ("missing coefficient", "kappa = 0.5", "", "4:11", "missing field `kappa`"),
    ("missing [potential]", "[potential]\nquartic = { kappa = 0.5 }\n", "", "1:1", "missing field `potential`"),
    ("missing [initial]", INITIAL, "", "1:1", "missing field `initial`"),
    ("missing [scheme]", "[scheme]\nsbp = \"SBP21\"\n", "", "1:1", "missing field `scheme`"),
    ("two potentials", POTENTIAL, "free = {}\nquartic = { kappa = 0.5 }", "5:11", "given: free and quartic"),
    ("no kind of potential", POTENTIAL, "", "3:1", "no potential is given"),
    (
        "potential without a table",
        POTENTIAL,
        "quartic = 0.5",
        "4:11",
        "'potential.quartic' must be a table, found float",
    ),
    ("potential as a list", POTENTIAL, "quartic = [0.5]", "4:11", "must be a table, found array"),
    ("system as a table", SOLVER, "system = { doubled = {} }", "24:10", "'solver.system' must be a string"),
    ("control character in the title", "\"Quartic\"", "\"Qu\\u001bartic\"", "1:9", "without control characters"),
    ("no tangent", "x_dot = 0.1\nt_dot = 1.0", "x_dot = 0.0\nt_dot = 0.0", "14:9", "t_dot and x_dot are both zero"),
    ("overflowing charge", "t_dot = 1.0", "t_dot = 1e200", "14:9", "overflows"),
    // Types
    ("string for a number", "x = 1.0", "x = \"one\"", "12:5", "string \"one\", expected a number"),
    ("boolean for a number", "x = 1.0", "x = true", "12:5", "boolean `true`, expected a number"),
    ("array for a number", "x = 1.0", "x = [1.0]", "12:5", "sequence, expected a number"),
    ("fraction for n_gamma", "32", "32.5", "18:11", "floating point `32.5`, expected a whole number"),
    ("negative n_gamma", "32", "-32", "18:11", "integer `-32`, expected a whole number, 0 or more"),
    ("number for a string", "\"SBP21\"", "21", "21:7", "integer `21`, expected a string"),
    ("string among the coefficients", POTENTIAL, "polynomial = { coefficients = [0.0, \"a\"] }", "4:37", "a number"),
    // Numbers that are none
    ("x = nan", "x = 1.0", "x = nan", "12:5", "initial.x must be a finite number"),
    ("t = -inf", "t = 0.0", "t = -inf", "11:5", "initial.t must be a finite number, got -inf"),
    ("gamma_f = inf", "gamma_f = 1.0", "gamma_f = inf", "17:11", "grid.gamma_f must be a finite number, got inf"),
    ("c = nan", "c = 1.0", "c = nan", "8:5", "particle.c must be a finite number"),
    ("kappa = inf", "kappa = 0.5", "kappa = inf", "4:21", "potential.quartic.kappa must be a finite number"),
    (
        "nan coefficient",
        POTENTIAL,
        "polynomial = { coefficients = [1.0, nan] }",
        "4:37",
        "coefficients.1 must be a finite number",
    ),
    ("number too large", "x = 1.0", "x = 1e999", "12:5", "overflow"),
    // Ranges and pairs
    ("n_gamma too small", "32", "2", "18:11", "SBP21 needs at least 3 points, got n_gamma = 2"),
    ("n_gamma too large", "32", "9223372036854775807", "18:11", "above the limit of 100000000 points"),
    ("empty range", "gamma_f = 1.0", "gamma_i = 1.0\ngamma_f = 1.0", "18:11", "greater than gamma_i = 1"),
    ("backward range", "gamma_f = 1.0", "gamma_f = -1.0", "17:11", "gamma_f = -1 must be greater than gamma_i = 0"),
    ("subnormal spacing", "gamma_f = 1.0", "gamma_f = 1e-320", "17:11", "too small or too large"),
    ("two ends", "gamma_f = 1.0", "gamma_f = 1.0\nt_f = 1.0", "18:7", "both gamma_f and t_f are given"),
    ("t_f before t", "gamma_f = 1.0", "t_f = -1.0", "17:7", "t_f = -1 must be later than the initial t = 0"),
    ("t_f, time stands", START_AND_END, "t_dot = 0.0\n\n[grid]\nt_f = 1.0", "17:7", "t_f needs t_dot > 0"),
    ("t_f, time runs back", START_AND_END, "t_dot = -1.0\n\n[grid]\nt_f = 1.0", "17:7", "t_f needs t_dot > 0"),
    ("two velocities", "x_dot = 0.1", "x_dot = 0.1\nvelocity = 0.1", "14:12", "both x_dot and velocity are given"),
    ("no velocity", "x_dot = 0.1\n", "", "10:1", "neither x_dot nor velocity is given"),
    ("mass = 0", "mass = 1.0", "mass = 0.0", "7:8", "particle.mass must be positive, got 0"),
    ("mass < 0", "mass = 1.0", "mass = -1.0", "7:8", "particle.mass must be positive, got -1"),
    ("c = 0", "c = 1.0", "c = 0.0", "8:5", "particle.c must be positive, got 0"),
    ("no iterations", SOLVER, "max_iterations = 0", "24:18", "max_iterations must be at least 1"),
    ("too few digits", SOLVER, "digits = 8", "24:10", "digits must be from 16 to 70, got 8"),
    ("unknown system", SOLVER, "system = \"double\"", "24:10", "unknown variant `double`, expected `physical-limit`"),
    ("no windows", "n_gamma = 32", "n_gamma = 32\nwindows = 0", "19:11", "windows must be at least 1"),
    ("unknown operator", "SBP21", "SBP22", "21:7", "unknown operator \"SBP22\", expected SBP21, SBP42, SBP63"),
    ("unknown form", "\"SBP21\"", "\"SBP21\"\nform = \"wek\"", "22:8", "unknown form \"wek\", expected strong or weak"),
    ("horizon at the start", "kappa = 0.5", "kappa = -0.5", "12:5", "g00(1.0) = 0.0\n"),
    ("start behind the horizon", "kappa = 0.5", "kappa = -5.0", "12:5", "g00(1.0) = -9.0\n"),
    ("unregularised limit", "\"SBP21\"", "\"SBP21\"\nregularised = false", "22:15", "needs solver.system"),
    (
        "unregularised weak form",
        "\"SBP21\"",
        "\"SBP21\"\nform = \"weak\"\nregularised = false",
        "23:15",
        "not possible with form = \"weak\"",
    ),
    ("tolerance = 0", SOLVER, "[expect]\nx_final = 1.0\ntolerance = 0.0", "26:13", "tolerance must be positive, got 0"),
    ("tolerance < 0", SOLVER, "[expect]\ntolerance = -1.0", "25:13", "tolerance must be positive, got -1"),
    ("no tolerance", SOLVER, "[expect]\nx_final = 1.0", "24:1", "t_final and x_final need a tolerance"),
    ("failure with an end", SOLVER, "[expect]\nstatus = \"stalled\"\nx_final = 1.0", "25:10", "no t_final or x_final"),
    // Not available yet
    (
        "too few nodes for SBP84",
        "n_gamma = 32\n\n[scheme]\nsbp = \"SBP21\"",
        "n_gamma = 15\n\n[scheme]\nsbp = \"SBP84\"",
        "18:11",
        "SBP84 needs at least 16 points, got n_gamma = 15",
    ),
    ("other nodes than the spectral element's", "SBP21", "GLL16", "18:11", "GLL16 has 16 nodes, got n_gamma = 32"),
    ("spectral element of one node", "SBP21", "GLL1", "21:7", "GLL<n> has from 2 to 64 nodes, got GLL1"),
    ("spectral element of too many nodes", "SBP21", "GLL65", "21:7", "GLL<n> has from 2 to 64 nodes, got GLL65"),
    ("spectral element without a number", "SBP21", "GLL", "21:7", "unknown operator \"GLL\""),
    (
        "too many windows",
        "n_gamma = 32",
        "n_gamma = 32\nwindows = 10000000",
        "19:11",
        "10000000 windows of 32 points are above the limit",
    ),
    ("too many digits", SOLVER, "digits = 71", "24:10", "digits must be from 16 to 70, got 71"),
    ("digits as a fraction", SOLVER, "digits = 40.5", "24:10", "expected a whole number"),
    ("digits as a string", SOLVER, "digits = \"40\"", "24:10", "expected a whole number"),
    ("accuracy and a grid", SOLVER, "accuracy = 1e-10", "18:11", "both solver.accuracy and grid.n_gamma are given"),
    ("accuracy of nothing", SOLVER, "accuracy = 0.0", "24:12", "accuracy must lie between 0 and 1, got 0"),
    ("accuracy that is not finite", SOLVER, "accuracy = nan", "24:12", "solver.accuracy must be a finite number"),
    ("accuracy as a string", SOLVER, "accuracy = \"high\"", "24:12", "expected a number"),
    (
        "accuracy and windows",
        "n_gamma = 32\n\n[scheme]\nsbp = \"SBP21\"\n\n[solver]",
        "windows = 2\n\n[solver]\naccuracy = 1e-8",
        "18:11",
        "both solver.accuracy and grid.windows are given",
    ),
    // TOML
    ("two equals signs", "x = 1.0", "x = = 1.0", "12:5", "`=`"),
    ("open table header", "[grid]", "[grid", "16:6", "unclosed table, expected `]`"),
    ("open string", "\"SBP21\"", "\"SBP21", "21:13", "expected `\"`"),
    ("bare word", "\"SBP21\"", "SBP21", "21:7", "string values must be quoted"),
    ("duplicate key", "x = 1.0", "x = 1.0\nx = 2.0", "13:1", "duplicate key"),
    ("duplicate quoted key", "x = 1.0", "x = 1.0\n\"x\" = 2.0", "13:1", "duplicate key"),
    ("duplicate table", "[solver]", "[grid]", "23:2", "duplicate key"),
    ("leading zero", "32", "032", "18:11", "leading zero"),
    ("letter that looks like x", "x = 1.0", "х = 1.0", "12:1", "invalid unquoted key"),
    ("wide characters before it", "\"Quartic\"", "\"四次 😀\" 4", "1:16", "expected newline"),
];

/// (name, parameters of a formula, line:column of the mistake, what the message contains); exit code 2.
pub(super) const PARAMETERS: &[(&str, &str, &str, &str)] = &[
    ("nan parameter", "a = nan", "4:50", "potential.formula.parameters.a must be a finite number"),
    ("infinite parameter", "a = 1.0, b = -inf", "4:59", "potential.formula.parameters.b must be a finite number"),
    ("string parameter", "a = 'q'", "4:50", "string \"q\", expected a number"),
    ("reserved name", "pi = 3.0", "4:51", "the parameter name 'pi' already has a meaning"),
    ("name of a function", "ln = 3.0", "4:51", "the parameter name 'ln' already has a meaning"),
    ("name with a blank", "'a b' = 1.0", "4:54", "the parameter name 'a b' cannot be written in a formula"),
];

/// (name, expression, character at which the mistake is, what the message contains); exit code 2.
pub(super) const FORMULAS: &[(&str, &str, usize, &str)] = &[
    ("unknown name", "x^2 + y", 7, "unknown name 'y'"),
    ("unknown function", "x*foo(x)", 3, "unknown function 'foo'"),
    ("missing parenthesis", "(x + 1", 7, "the ')' that closes character 1, found the end"),
    ("missing inner parenthesis", "sin(cos(x)", 11, "the ')' that closes character 4, found the end"),
    ("closing parenthesis too many", "x)", 2, "found ')'"),
    ("trailing operator", "x +", 4, "found the end"),
    ("operator without its left side", "*x", 1, "found '*'"),
    ("two operators", "x**2", 3, "found '*'"),
    ("product without *", "2x", 1, "a product is written with *"),
    ("factors side by side", "2 x", 3, "expected an operator, found 'x'"),
    ("parentheses side by side", "(x)(x)", 4, "expected an operator, found '('"),
    ("blank", "  ", 3, "found the end"),
    ("nothing in parentheses", "x + ()", 6, "found ')'"),
    ("function without parentheses", "x + sin x", 5, "the function 'sin' needs its argument in parentheses"),
    ("two arguments", "sin(x, 1)", 6, "found ','"),
    ("variable as a function", "x(1)", 1, "'x' is not a function"),
    ("stray character", "x # 2", 3, "expected an operator, found '#'"),
    ("superscript", "x²", 2, "found '²'"),
    ("minus sign of typesetting", "x − 1", 3, "found '−'"),
    ("wide characters", "x + 漢", 5, "found '漢'"),
    ("number without exponent", "1e*x", 1, "not a finite number"),
    ("number with two points", "1.2.3", 1, "not a finite number"),
    ("number too large", "1e999*x", 1, "not a finite number"),
];

/// (name, arguments, exit code, what standard error contains). The files named are those of [`Workspace::new`].
pub(super) const COMMAND_LINES: &[(&str, &[&str], i32, &[&str])] = &[
    ("unknown subcommand", &["solve", "case.toml"], 2, &["unrecognized subcommand 'solve'", "--help"]),
    ("unknown option", &["run", "case.toml", "--fast"], 2, &["unexpected argument '--fast'"]),
    ("no case", &["run"], 2, &["<CASE>", "Usage:"]),
    ("--out with --stdout", &["run", "case.toml", "--out", "new", "--stdout"], 2, &["'--out <DIR>'", "'--stdout'"]),
    ("check with --out", &["check", "case.toml", "--out", "new"], 2, &["unexpected argument '--out'"]),
    ("--set without =", &["run", "case.toml", "--out", "new", "--set", "c"], 2, &["--set c: expected KEY=VALUE"]),
    ("--set without value", &["run", "case.toml", "--set", "grid.n_gamma="], 2, &["the value is missing"]),
    ("--set without key", &["run", "case.toml", "--set", "=3"], 2, &["'' is not a dotted key"]),
    ("--set bad key", &["run", "case.toml", "--set", "grid..x=3"], 2, &["'grid..x' is not a dotted key"]),
    ("--set through a number", &["run", "case.toml", "--set", "grid.n_gamma.x=3"], 2, &["'n_gamma' is not a table"]),
    ("--set unknown key", &["run", "case.toml", "--set", "grid.n=3"], 2, &["unknown field `n`", "n=3:19:1\n"]),
    ("--set wrong type", &["run", "case.toml", "--set", "initial.x=one"], 2, &["string \"one\"", "x=one:12:5\n"]),
    ("--set not finite", &["run", "case.toml", "--set", "initial.x=nan"], 2, &["finite number", "x=nan:12:5\n"]),
    (
        "second --set",
        &["run", "case.toml", "--set", "grid.n_gamma=7", "--set", "scheme.sbp=SBP42"],
        2,
        &["SBP42 needs at least 8 points, got n_gamma = 7", "--set grid.n_gamma=7 --set scheme.sbp=SBP42:18:11\n"],
    ),
    (
        "accuracy with digits",
        &["run", "case.toml", "--set", "solver={accuracy=1e-8, digits=40}", "--set", "grid={}"],
        2,
        &["solver.accuracy and solver.digits exclude each other"],
    ),
    (
        "accuracy with the doubled system",
        &["run", "case.toml", "--set", "solver.accuracy=1e-8", "--set", "solver.system=doubled"],
        2,
        &["solver.accuracy needs system = \"physical-limit\""],
    ),
    (
        "two ends by --set",
        &["run", "case.toml", "--set", "grid.t_f=1.0", "--set", "grid.gamma_f=1.0"],
        2,
        &["both gamma_f and t_f are given"],
    ),
    (
        "accuracy and nodes by --set",
        &["run", "case.toml", "--set", "solver.accuracy=1e-8", "--set", "grid.n_gamma=20"],
        2,
        &["both solver.accuracy and grid.n_gamma are given"],
    ),
    (
        "--samples-only without samples",
        &["run", "case.toml", "--samples-only"],
        2,
        &["--samples-only needs --sample-t"],
    ),
    (
        "samples on standard output beside the table",
        &["run", "case.toml", "--stdout", "--sample-t", "0:1:0.1"],
        2,
        &["it needs --samples-only"],
    ),
    ("check of an invalid case", &["check", "case.toml", "--set", "particle.c=0"], 2, &["particle.c", "c=0:8:5\n"]),
    ("missing file", &["run", "none.toml"], 1, &["cannot read the case file none.toml"]),
    ("directory as case", &["run", "earlier"], 1, &["cannot read the case file earlier"]),
    ("not UTF-8", &["run", "latin-1.toml"], 2, &["latin-1.toml: the case is not UTF-8 text"]),
    ("output is a file", &["run", "case.toml", "--out", "case.toml"], 1, &["the output directory case.toml"]),
    ("output below a file", &["run", "case.toml", "--out", "case.toml/x"], 1, &["the output directory case.toml/x"]),
    ("table is a directory", &["run", "case.toml", "--out", "blocked"], 1, &["trajectory.csv: it is a directory"]),
    ("no [expect]", &["check", "case.toml", "--run", "--quiet"], 2, &["the case has no [expect] table"]),
    (
        "wrong number",
        &["check", "case.toml", "--run", "--quiet", "--set", "expect={x_final=2.0, tolerance=1e-6}"],
        5,
        &["the case does not meet its [expect] table: x_final = 0.16018", "of 2.0 (tolerance 1e-6)"],
    ),
    (
        "wrong status",
        &["check", "case.toml", "--run", "--quiet", "--set", "expect.status=singular"],
        5,
        &["expected status singular, found converged"],
    ),
    ("horizon on --stdout", &["run", HORIZON, "--stdout"], 4, &["leaves the domain at gamma = "]),
];
