//! Texts in pages: whatever characters they have, they end no element, attribute or script, and readers
//! see them as they are.

use maud::html;
use meliora_base::json;
use proptest::prelude::*;

/// Texts made of what means something in HTML, and of any other characters.
fn text() -> impl Strategy<Value = String> {
    let special = prop::sample::select(vec![
        "<",
        ">",
        "&",
        "\"",
        "'",
        "&amp;",
        "&lt;",
        "&#60;",
        "</p>",
        "</script>",
        "<!--",
        "-->",
        "]]>",
        "<script>",
        "\\u003c",
        "a",
        " ",
        "é",
    ]);
    let part = prop_oneof![3 => special.prop_map(str::to_owned), 1 => any::<char>().prop_map(String::from)];
    prop::collection::vec(part, 0..8).prop_map(|parts| parts.concat())
}

/// Reads the text of an element or an attribute; `None` if something in it could end it, or is an unknown entity.
fn read(mut escaped: &str) -> Option<String> {
    let mut text = String::new();
    while let Some(c) = escaped.chars().next() {
        let (read, length) = match c {
            '<' | '>' | '"' => return None,
            '&' => {
                let entities = [("&amp;", '&'), ("&lt;", '<'), ("&gt;", '>'), ("&quot;", '"')];
                let (entity, read) = entities.into_iter().find(|(entity, _)| escaped.starts_with(entity))?;
                (read, entity.len())
            }
            c => (c, c.len_utf8()),
        };
        text.push(read);
        escaped = &escaped[length..];
    }
    Some(text)
}

proptest! {
    #![proptest_config(meliora_amount::random(2000))]

    #[test]
    fn texts_end_no_element_and_no_attribute(text in text()) {
        let page = html! { p title=(text) { (text) } }.into_string();
        let inside = page.strip_prefix("<p title=\"").and_then(|rest| rest.strip_suffix("</p>"));
        let (title, content) = inside.and_then(|inside| inside.split_once("\">")).unwrap();
        prop_assert_eq!(read(title), Some(text.clone()), "{}", title);
        prop_assert_eq!(read(content), Some(text), "{}", content);
    }

    #[test]
    fn texts_end_no_script(text in text()) {
        let script = json::script(&[&text]).unwrap();
        prop_assert!(!script.contains('<'), "{script}");
        prop_assert_eq!(serde_json::from_str::<[String; 1]>(&script).unwrap(), [text]);
    }
}
