//! Options whose values are an enum of the library.

use std::ffi::OsStr;
use std::marker::PhantomData;
use std::str::FromStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error};
use meliora_base::slip;
use strum::{EnumMessage, VariantArray};

/// Returns a parser of the names of an enum. Its variants are the possible values, and their doc
/// comments are the help texts.
pub(super) fn by_name<T: ByName>() -> impl TypedValueParser<Value = T> {
    Names(PhantomData)
}

/// An enum whose variants have names and doc comments.
pub(super) trait ByName:
    Copy + EnumMessage + FromStr + Into<&'static str> + Send + Sync + VariantArray
{
}

impl<T: Copy + EnumMessage + FromStr + Into<&'static str> + Send + Sync + VariantArray> ByName for T {}

/// A parser like clap's, except that it suggests a value only for a slip: not `transition` for `strict`.
#[derive(Clone)]
struct Names<T>(PhantomData<T>);

impl<T: ByName> TypedValueParser for Names<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        let text = value.to_string_lossy();
        text.parse().map_err(|_| {
            let names = || T::VARIANTS.iter().map(|&variant| variant.into());
            let mut error = Error::new(ErrorKind::InvalidValue).with_cmd(command);
            if let Some(arg) = arg {
                error.insert(ContextKind::InvalidArg, ContextValue::String(arg.to_string()));
            }
            error.insert(ContextKind::InvalidValue, ContextValue::String(text.to_string()));
            let known = names().map(str::to_owned).collect();
            error.insert(ContextKind::ValidValue, ContextValue::Strings(known));
            if let Some(meant) = slip::meant(names(), &text) {
                error.insert(ContextKind::SuggestedValue, ContextValue::String(meant.to_owned()));
            }
            error
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |&variant: &T| {
            let help = variant.get_documentation().unwrap_or_default().replace('\n', " ");
            PossibleValue::new(variant.into()).help(help.trim().trim_end_matches('.').to_owned())
        };
        Some(Box::new(T::VARIANTS.iter().map(value)))
    }
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
                "Drop weakening successors and keep the others, as in the paper's table. The dropped successors \
                 may still occur, so a strategy may weaken"
            )
        );
    }

    #[test]
    fn only_a_slip_is_taken_for_a_value() {
        let advice = |value: &str| {
            let arg = Arg::new("safety").long("safety").value_parser(by_name::<Safety>());
            let parsed = Command::new("m").arg(arg).try_get_matches_from(["m", "--safety", value]);
            parsed.err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(advice("strict").contains("[possible values: action, transition, prefix]"));
        assert!(
            !advice("strict").contains("similar")
                && advice("prefx").contains("similar value exists: 'prefix'")
        );
    }
}
