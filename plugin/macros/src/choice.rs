//! `#[derive(Choice)]`: an enumeration whose values have names, for modulations.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result};

use crate::text::{c, kebab};

/// Generates the implementation of `Modulated` for `input`, whose names are in the module `derived`.
pub(crate) fn derive(input: &DeriveInput, derived: &TokenStream) -> Result<TokenStream> {
    let ident = &input.ident;
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(ident, "a choice is an enumeration"));
    };
    if !input.generics.params.is_empty() {
        return Err(Error::new_spanned(
            &input.generics,
            "a choice has no generic parameters, because each of its values has one name",
        ));
    }
    let mut is_byte = false;
    for attribute in input
        .attrs
        .iter()
        .filter(|attribute| attribute.path().is_ident("repr"))
    {
        attribute.parse_nested_meta(|meta| {
            is_byte |= meta.path.is_ident("u8");
            Ok(())
        })?;
    }
    if !is_byte {
        return Err(Error::new_spanned(
            ident,
            "a choice is a byte, so that other languages can read it; add `#[repr(u8)]`",
        ));
    }
    if data.variants.is_empty() {
        return Err(Error::new_spanned(ident, "a choice has at least one variant"));
    }
    let (mut names, mut arms) = (Vec::new(), Vec::new());
    for (number, variant) in data.variants.iter().enumerate() {
        if !matches!(variant.fields, Fields::Unit) {
            return Err(Error::new_spanned(
                &variant.fields,
                "the variants of a choice have no fields",
            ));
        }
        if let Some((_, number)) = &variant.discriminant {
            return Err(Error::new_spanned(
                number,
                "choices are numbered from 0 on; omit the number",
            ));
        }
        let Ok(number) = u8::try_from(number) else {
            return Err(Error::new_spanned(variant, "there are at most 256 choices"));
        };
        let (variant, name) = (&variant.ident, c(&kebab(&variant.ident.to_string())));
        names.push(quote!(#name.as_ptr()));
        arms.push(quote!(#number => ::core::option::Option::Some(Self::#variant)));
    }
    Ok(quote! {
        // SAFETY: its `repr` makes it a byte, and its variants have the numbers 0, 1, 2 and so on.
        unsafe impl #derived::Modulated for #ident {
            type Wire = u8;

            const CHOICES: &'static [*const ::core::ffi::c_char] = &[#(#names),*];

            fn of(wire: &u8) -> ::core::option::Option<Self> {
                match *wire {
                    #(#arms,)*
                    _ => ::core::option::Option::None,
                }
            }
        }
    })
}
