//! Options whose values are an enum of the library.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use strum::{EnumMessage, VariantArray};

/// Returns a parser of the names of an enum. Its variants are the possible values, and their doc
/// comments are the help texts.
pub(super) fn by_name<T>() -> impl TypedValueParser<Value = T>
where
    T: Copy + EnumMessage + FromStr + Into<&'static str> + Send + Sync + VariantArray,
    T::Err: std::error::Error + Send + Sync,
{
    let value = |&variant: &T| {
        let help = variant.get_documentation().unwrap_or_default().replace('\n', " ");
        PossibleValue::new(variant.into()).help(help.trim().trim_end_matches('.').to_owned())
    };
    PossibleValuesParser::new(T::VARIANTS.iter().map(value)).try_map(|name| name.parse())
}

#[cfg(test)]
mod tests {
    use meliora_planning::Safety;

    use super::*;

    #[test]
    fn help_texts_are_the_doc_comments_of_the_variants() {
        let parser = by_name::<Safety>();
        let values: Vec<_> = parser.possible_values().into_iter().flatten().collect();
        let names: Vec<_> = values.iter().map(PossibleValue::get_name).collect();
        assert_eq!(names, ["action", "transition", "prefix"]);
        let help = values[1].get_help().map(ToString::to_string);
        assert_eq!(
            help.as_deref(),
            Some(
                "Drop weakening successors and keep the others, as in the paper: such an action may still weaken"
            )
        );
    }
}
