//! Enums whose values have names in options, reports and JSON.

/// Declares an enum without data whose values have names: its variants in lower case. The names are
/// parsed (`EnumString`), shown (`name`), listed with their descriptions (`ALL`,
/// `EnumMessage`), and written to JSON and its schema.
///
/// ```
/// meliora_base::named! {
///     /// A side of a road.
///     pub enum Side {
///         /// The left side.
///         Left,
///         /// The right side.
///         Right,
///     }
/// }
///
/// assert_eq!(Side::Right.name(), "right");
/// assert_eq!("left".parse(), Ok(Side::Left));
/// assert_eq!(Side::ALL, [Side::Left, Side::Right]);
/// ```
#[macro_export]
macro_rules! named {
    ($(#[$attribute:meta])* pub enum $name:ident { $($variants:tt)* }) => {
        $(#[$attribute])*
        #[derive(
            Debug,
            Clone,
            Copy,
            PartialEq,
            Eq,
            Hash,
            serde::Serialize,
            strum::EnumMessage,
            strum::EnumString,
            strum::IntoStaticStr,
            strum::VariantArray,
            schemars::JsonSchema,
        )]
        #[serde(rename_all = "lowercase")]
        #[strum(serialize_all = "lowercase")]
        pub enum $name { $($variants)* }

        impl $name {
            /// All values; the default, if there is one, is first.
            pub const ALL: &'static [$name] = <$name as strum::VariantArray>::VARIANTS;

            /// Returns the name in files, options and reports.
            pub fn name(self) -> &'static str {
                self.into()
            }
        }
    };
}
