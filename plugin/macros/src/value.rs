//! `#[derive(Value)]`: the table of a structure, with assertions that its fields cover every byte.

use proc_macro2::{Ident, TokenStream};
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Attribute, Data, DeriveInput, Error, Fields, LitStr, Result};

use crate::text::{c, doc, unit};

/// Generates the table of `input`, whose names are in the module `derived`.
pub(crate) fn derive(input: &DeriveInput, derived: &TokenStream) -> Result<TokenStream> {
    let ident = &input.ident;
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(
            ident,
            "a value is a structure; some bytes of an enum or union would be invalid",
        ));
    };
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new_spanned(
            ident,
            "a value has named fields, because tools show them by name",
        ));
    };
    if !input.generics.params.is_empty() {
        return Err(Error::new_spanned(
            &input.generics,
            "a value has no generic parameters, because each type has one name",
        ));
    }
    require_c_layout(input)?;

    let default_name = format!(
        "{}/msg/{ident}",
        std::env::var("CARGO_PKG_NAME")
            .unwrap_or_default()
            .replace('-', "_")
    );
    let name = c(&option(&input.attrs, "name")?.map_or(default_name, |name| name.value()));
    let type_doc = c(&doc(&input.attrs));

    let mut tables = Vec::new();
    let mut sizes = Vec::new();
    for field in &fields.named {
        let (ty, field_ident) = (&field.ty, &field.ident);
        let field_name = c(&field_ident.as_ref().map(plain).unwrap_or_default());
        let field_doc = c(&doc(&field.attrs));
        let unit = c(&unit(option(&field.attrs, "unit")?.as_ref())?);
        tables.push(quote_spanned! { ty.span() =>
            #derived::field::<#ty>(::core::mem::offset_of!(#ident, #field_ident), #field_name, #field_doc, #unit)
        });
        sizes.push(quote!(::core::mem::size_of::<#ty>()));
    }
    let gap = format!(
        "`{ident}` has an alignment gap; fill it with a `Padding<N>` field, or order its fields by size"
    );
    let covered = quote_spanned! { ident.span() =>
        const _: () = assert!(::core::mem::size_of::<#ident>() == 0 #(+ #sizes)*, #gap);
    };
    Ok(quote! {
        const _: () = {
            #covered
            const FIELDS: &[#derived::raw::Field] = &[#(#tables),*];
            // SAFETY: it is in C layout. The assertion above shows that its fields cover it without a gap.
            // Every pattern of a field's bytes is valid because each field is a `Part`.
            unsafe impl #derived::Value for #ident {
                const TYPE: &'static #derived::raw::Type = &#derived::structure::<#ident>(#name, #type_doc, FIELDS);
            }
            // SAFETY: as above.
            unsafe impl #derived::Part for #ident {
                const SHAPE: #derived::FieldLayout = #derived::FieldLayout::structure(<#ident as #derived::Value>::TYPE);
            }
        };
    })
}

/// Generates the traits of a value with the table of a byte, for a value or a choice with a mistake.
pub(crate) fn placeholder(ident: &Ident, derived: &TokenStream) -> TokenStream {
    quote! {
        // SAFETY: the code does not compile, because an error is beside this.
        unsafe impl #derived::Value for #ident {
            const TYPE: &'static #derived::raw::Type = <u8 as #derived::Value>::TYPE;
        }
        // SAFETY: as above.
        unsafe impl #derived::Part for #ident {
            const SHAPE: #derived::FieldLayout = <u8 as #derived::Part>::SHAPE;
        }
    }
}

/// Returns the name of a field without the prefix `r#`.
fn plain(ident: &Ident) -> String {
    ident.to_string().trim_start_matches("r#").to_owned()
}

fn require_c_layout(input: &DeriveInput) -> Result<()> {
    let mut c_layout = false;
    for attribute in input
        .attrs
        .iter()
        .filter(|attribute| attribute.path().is_ident("repr"))
    {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident("C") {
                return Err(meta.error("a value has only `#[repr(C)]`"));
            }
            c_layout = true;
            Ok(())
        })?;
    }
    if c_layout {
        return Ok(());
    }
    Err(Error::new_spanned(
        &input.ident,
        "a value is laid out as in C, so that other languages can read it; add `#[repr(C)]`",
    ))
}

/// Returns the one option `name` of `#[value(...)]`.
fn option(attributes: &[Attribute], name: &str) -> Result<Option<LitStr>> {
    let mut found = None;
    for attribute in attributes
        .iter()
        .filter(|attribute| attribute.path().is_ident("value"))
    {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident(name) {
                return Err(meta.error(format!("only `{name} = \"...\"` is allowed")));
            }
            found = Some(meta.value()?.parse()?);
            Ok(())
        })?;
    }
    Ok(found)
}
