//! The texts of tables: doc comments, names, units and durations.

use proc_macro2::Literal;
use syn::{Attribute, Error, Expr, ExprLit, Lit, LitStr, Meta, Result};

/// Returns the text of an item's doc comments. The blank after each `///` is removed, and so are the brackets
/// of links, which have a meaning only in rustdoc.
pub(crate) fn doc(attributes: &[Attribute]) -> String {
    let mut lines = Vec::new();
    for attribute in attributes {
        if let Meta::NameValue(pair) = &attribute.meta
            && pair.path.is_ident("doc")
            && let Expr::Lit(ExprLit {
                lit: Lit::Str(text), ..
            }) = &pair.value
        {
            for line in text.value().split('\n') {
                lines.push(line.strip_prefix(' ').unwrap_or(line).trim_end().to_owned());
            }
        }
    }
    lines.join("\n").trim().replace("[`", "`").replace("`]", "`")
}

/// Converts `text` to a C string, up to its first NUL.
pub(crate) fn c(text: &str) -> Literal {
    let bytes: Vec<u8> = text.bytes().take_while(|&byte| byte != 0).collect();
    let text = std::ffi::CString::new(bytes).unwrap_or_default();
    Literal::c_string(&text)
}

/// Converts `StopNow` to `stop-now`.
pub(crate) fn kebab(name: &str) -> String {
    let mut out = String::new();
    let letters: Vec<char> = name.chars().collect();
    for (at, &letter) in letters.iter().enumerate() {
        let after_small = at > 0 && !letters[at - 1].is_uppercase();
        let before_small = at > 0 && letters.get(at + 1).is_some_and(|next| next.is_lowercase());
        if letter.is_uppercase() && (after_small || before_small) {
            out.push('-');
        }
        out.extend(letter.to_lowercase());
    }
    out
}

/// Refuses a name that the host would refuse.
pub(crate) fn check_name(name: &str, span: proc_macro2::Span) -> Result<()> {
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > 64 || !name.chars().all(legal) {
        return Err(Error::new(
            span,
            format!("`{name}` is not a name; use 1 to 64 letters, digits, `_` and `-`"),
        ));
    }
    Ok(())
}

/// Returns the text of a unit, empty if there is none. Refuses an unknown unit.
pub(crate) fn unit(text: Option<&LitStr>) -> Result<String> {
    let Some(text) = text else {
        return Ok(String::new());
    };
    let unit = text.value();
    match jde_abi::unit::check(&unit) {
        Ok(()) => Ok(unit),
        Err(error) => Err(Error::new(text.span(), error)),
    }
}

/// Converts a duration such as "200ms" to nanoseconds.
pub(crate) fn duration(text: &LitStr) -> Result<u64> {
    let value = text.value();
    let error = || {
        Error::new(
            text.span(),
            format!(
                "`{value}` is not a duration; write a number and its unit: \"75ms\", \"2s\", \"500us\", \"100ns\""
            ),
        )
    };
    let unit = value.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number: f64 = value[..value.len() - unit.len()].parse().map_err(|_| error())?;
    let scale = match unit.trim() {
        "ns" => 1.0,
        "us" => 1e3,
        "ms" => 1e6,
        "s" => 1e9,
        _ => return Err(error()),
    };
    let nanos = (number * scale).round();
    if !(1.0..=9e18).contains(&nanos) {
        return Err(Error::new(text.span(), "a duration is at least 1 ns and finite"));
    }
    Ok(nanos as u64)
}
