//! Doors: what is long to compile and generic in its numbers is compiled in its own package, once for each kind.

/// A trait of functions that are written once, generic in their numbers, and compiled where they stand for `f64` and
/// for [`Extended`](crate::scalar::Extended). A generic function is otherwise compiled again, with everything that it
/// calls, by every package and every test that uses it.
///
/// Each function names the generic one behind it. `Self` stands for the numbers. With `<G: Bound> for [Metric, …]`
/// the functions are generic in a space-time G, too, and are compiled for each of these, which are types with the
/// numbers as their parameter.
#[macro_export]
#[doc(hidden)]
macro_rules! compiled {
    (
        $(#[$about:meta])*
        pub trait $name:ident {
            $(fn $door:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty = $behind:expr;)*
        }
    ) => {
        $(#[$about])*
        #[doc(hidden)]
        pub trait $name: $crate::scalar::Real {
            $(
                /// What is behind a public function, which calls it.
                fn $door($($argument: $type),*) -> $result;
            )*
        }

        $crate::compiled!(@for f64, $name { $($door($($argument: $type),*) -> $result = $behind;)* });
        $crate::compiled!(
            @for $crate::scalar::Extended, $name { $($door($($argument: $type),*) -> $result = $behind;)* }
        );
    };
    (
        $(#[$about:meta])*
        pub trait $name:ident<$space:ident: $bound:ident> for [$($each:ident),*] {
            $(fn $door:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty = $behind:expr;)*
        }
    ) => {
        $(#[$about])*
        #[doc(hidden)]
        pub trait $name<$space: $bound<Self>>: $crate::scalar::Real {
            $(
                /// What is behind a public function, which calls it.
                fn $door($($argument: $type),*) -> $result;
            )*
        }

        $crate::compiled!(
            @each [$($each),*] $space, $name { $($door($($argument: $type),*) -> $result = $behind;)* }
        );
    };
    (@each [$($each:ident),*] $space:ident, $name:ident $doors:tt) => {
        $(
            const _: () = {
                type $space = $each<f64>;
                $crate::compiled!(@for f64, $name<$space> $doors);
            };
            const _: () = {
                type $space = $each<$crate::scalar::Extended>;
                $crate::compiled!(@for $crate::scalar::Extended, $name<$space> $doors);
            };
        )*
    };
    (
        @for $number:ty,
        $name:ident $(<$space:ident>)?
        { $($door:ident($($argument:ident: $type:ty),*) -> $result:ty = $behind:expr;)* }
    ) => {
        impl $name $(<$space>)? for $number {
            $(
                #[inline(never)]
                fn $door($($argument: $type),*) -> $result {
                    $behind($($argument),*)
                }
            )*
        }
    };
}
