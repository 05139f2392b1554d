//! Dotted paths of keys, and the positions at which values are blamed.

use toml::Spanned;
use toml::de::DeValue;

/// Returns the dotted path of a key.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Returns the byte offset at which a value is reported: that of its key for a table, whose own span
/// may be its header.
pub(super) fn blame(
    key: &Spanned<std::borrow::Cow<'_, str>>,
    value: &Spanned<DeValue<'_>>,
) -> usize {
    match value.get_ref() {
        DeValue::Table(_) => key.span().start,
        _ => value.span().start,
    }
}
