//! Tables of numbers, each with a default and a range.

/// A setting out of its range.
#[derive(Debug, Clone, PartialEq)]
pub struct SettingError {
    /// Dotted key below `[indicators]`.
    pub key: String,
    /// What stands there.
    pub value: f64,
    /// What may stand there.
    pub allowed: String,
}

impl std::fmt::Display for SettingError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` is {}, allowed is {}", self.key, self.value, self.allowed)
    }
}

impl std::error::Error for SettingError {}

/// A setting, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct SettingEntry {
    /// Dotted key below `[indicators]`.
    pub key: String,
    /// What it says, with its unit.
    pub words: &'static str,
    /// What holds.
    pub value: f64,
    /// What holds where a config is silent.
    pub default: f64,
    /// Least and greatest value.
    pub range: [f64; 2],
}

/// Declares a table of numbers: fields with default, least and greatest value, and its check.
macro_rules! table {
    ($(#[$meta:meta])* $name:ident { $($(#[doc = $words:literal])+ $field:ident = $default:literal in $low:literal..$high:literal;)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name { $($(#[doc = $words])+ pub $field: f64,)+ }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $name {
            fn entries(&self, table: &'static str) -> Vec<SettingEntry> {
                vec![$(SettingEntry {
                    key: format!("{table}.{}", stringify!($field)),
                    words: concat!($($words),+).trim_ascii(),
                    value: self.$field,
                    default: $default,
                    range: [$low, $high],
                },)+]
            }

            fn wrong(&self, table: &'static str) -> Vec<SettingError> {
                let mut wrong = Vec::new();
                $(if !($low..=$high).contains(&self.$field) {
                    wrong.push(SettingError {
                        key: format!("{table}.{}", stringify!($field)),
                        value: self.$field,
                        allowed: format!("{} to {}", $low, $high),
                    });
                })+
                wrong
            }
        }
    };
}

pub(super) use table;
