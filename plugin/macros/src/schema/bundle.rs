//! `#[derive(PortBundle)]`: ports that several types of schema have.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::{DeriveInput, Error, Result};

use super::field::{Role, SchemaField};
use super::members::Members;
use super::{check_names, fields};

/// Generates the implementation of `PortBundle` for `input`.
pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let fields = fields(input, "bundle")?;
    let fields = fields.iter().map(SchemaField::of).collect::<Result<Vec<_>>>()?;
    for field in &fields {
        if matches!(
            field.role,
            Role::Memory | Role::Child { .. } | Role::Modulates { .. } | Role::List { .. }
        ) {
            return Err(Error::new(
                field.span,
                "a bundle has imports, exports, modulations, commands, actuators and other bundles only",
            ));
        }
    }
    check_names(&fields)?;
    Ok(implementation(&input.ident, &Members::of(&fields)))
}

/// Generates an implementation without ports, for a structure with a mistake.
pub(crate) fn placeholder(ident: &Ident) -> TokenStream {
    let mut members = Members::of(&[]);
    members.build = quote!(::core::unreachable!());
    implementation(ident, &members)
}

fn implementation(ident: &Ident, members: &Members<'_>) -> TokenStream {
    let (tables, count, build) = (members.ports.tables(), members.ports.count(), &members.build);
    quote! {
        const _: () = {
            use ::jde_schema::derived;

            // SAFETY: tables and values are generated from the same fields in the same order.
            unsafe impl derived::PortBundle for #ident {
                const PORTS: &'static [derived::raw::Port] = {
                    const PORTS: [derived::raw::Port; #count] = derived::join(#tables);
                    &PORTS
                };

                #[allow(unused_variables, reason = "only ports use it")]
                unsafe fn build(ports: &'static [derived::raw::Port], first: u32) -> Self {
                    #build
                }
            }
        };
    }
}
