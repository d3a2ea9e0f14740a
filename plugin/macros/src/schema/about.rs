//! `#[schema(...)]`: the description of a schema type, apart from its fields.

use proc_macro2::TokenStream;
use quote::quote;
use syn::spanned::Spanned;
use syn::{DeriveInput, Error, LitStr, Result};

use crate::text::{check_name, doc, duration, kebab};

/// The description of a schema type, apart from its fields.
pub(super) struct About {
    pub(super) name: String,
    pub(super) doc: String,
    pub(super) kind: Kind,
    pub(super) period_ns: u64,
    pub(super) budget_ns: u64,
}

/// The kinds of schema.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Perceptive,
    Motor,
    Driver,
}

impl About {
    pub(super) fn of(input: &DeriveInput) -> Result<Self> {
        let mut name = None;
        let mut kind = None;
        let mut period_ns = None;
        let mut budget_ns = 0;
        let mut span = input.ident.span();
        for attribute in input
            .attrs
            .iter()
            .filter(|attribute| attribute.path().is_ident("schema"))
        {
            span = attribute.span();
            attribute.parse_nested_meta(|meta| {
                let mut set_kind = |new_kind| match kind.replace(new_kind) {
                    None => Ok(()),
                    Some(_) => Err(meta.error("a schema has exactly one kind: motor, perceptive or driver")),
                };
                if meta.path.is_ident("motor") {
                    set_kind(Kind::Motor)
                } else if meta.path.is_ident("perceptive") {
                    set_kind(Kind::Perceptive)
                } else if meta.path.is_ident("driver") {
                    set_kind(Kind::Driver)
                } else if meta.path.is_ident("period") {
                    period_ns = Some(duration(&meta.value()?.parse()?)?);
                    Ok(())
                } else if meta.path.is_ident("budget") {
                    budget_ns = duration(&meta.value()?.parse()?)?;
                    Ok(())
                } else if meta.path.is_ident("name") {
                    let text: LitStr = meta.value()?.parse()?;
                    check_name(&text.value(), text.span())?;
                    name = Some(text.value());
                    Ok(())
                } else {
                    Err(meta.error(
                        "unknown option; use motor, perceptive or driver, period = \"75ms\", budget = \"5ms\", name = \"...\"",
                    ))
                }
            })?;
        }
        let Some(kind) = kind else {
            return Err(Error::new(
                span,
                "state the kind of the schema: #[schema(motor, period = \"75ms\")], or perceptive, or driver",
            ));
        };
        let Some(period_ns) = period_ns else {
            return Err(Error::new(
                span,
                "state the default period of its iterations: period = \"75ms\"",
            ));
        };
        Ok(Self {
            name: name.unwrap_or_else(|| kebab(&input.ident.to_string())),
            doc: doc(&input.attrs),
            kind,
            period_ns,
            budget_ns,
        })
    }
}

impl Kind {
    /// Returns the constant of the ABI for this kind.
    pub(super) fn constant(self) -> TokenStream {
        match self {
            Self::Perceptive => quote!(derived::raw::PERCEPTIVE),
            Self::Motor => quote!(derived::raw::MOTOR),
            Self::Driver => quote!(derived::raw::DRIVER),
        }
    }
}
