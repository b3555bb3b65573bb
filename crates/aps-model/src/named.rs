//! Types whose values have names.

/// Prints a type by the `name` of a value, and reads it as one of `ALL`. With a list of names it declares these two as well.
macro_rules! named {
    ($type:ident, $what:literal: $($value:ident = $name:literal),*) => {
        impl $type {
            #[doc = concat!("Every ", $what, ".")]
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$value),*];

            /// Returns the name on the command line and in files.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)*
                }
            }
        }

        named!($type, $what);
    };
    ($type:ty, $what:literal) => {
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::Error;

            fn from_str(name: &str) -> $crate::Result<Self> {
                let found = Self::ALL.into_iter().find(|one| one.name() == name);
                found.ok_or_else(|| $crate::Error::UnknownName {
                    what: $what,
                    found: name.to_owned(),
                    known: Self::ALL.map(Self::name).join(", "),
                })
            }
        }
    };
}

pub(crate) use named;
