//! What the fields of a structure become: tables in one order, and the expression that builds the structure.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::Type;
use syn::spanned::Spanned;

use super::field::{Role, SchemaField};

/// The tables of a structure, and the expression that builds it from `ports`, the table of the whole schema, and
/// `first`, the number of its first port there.
pub(super) struct Members<'f> {
    pub(super) ports: Ports<'f>,
    pub(super) roles: Vec<TokenStream>,
    pub(super) lists: Vec<TokenStream>,
    pub(super) list_members: Vec<&'f syn::Ident>,
    pub(super) build: TokenStream,
}

/// The tables of ports in the order of the fields: runs of own ones, and those of bundles.
#[derive(Default)]
pub(super) struct Ports<'f> {
    parts: Vec<TokenStream>,
    run: Vec<TokenStream>,
    own: usize,
    bundles: Vec<&'f Type>,
}

impl<'f> Members<'f> {
    pub(super) fn of(fields: &'f [SchemaField]) -> Self {
        let children: Vec<&SchemaField> = fields.iter().filter(|field| field.is_child()).collect();
        let position = |name: &str| children.iter().position(|child| child.name == name);
        let mut ports = Ports::default();
        let (mut roles, mut lists, mut list_members, mut values) =
            <(Vec<_>, Vec<_>, Vec<_>, Vec<_>)>::default();
        for field in fields {
            let (member, ty) = (&field.member, &field.ty);
            // SAFETY (of the generated code): the table of that number has this kind and this type.
            let port = |number, shown: &str| quote!(unsafe { <#ty>::new(ports, first + #number, #shown) });
            let value = match &field.role {
                Role::Memory => quote_spanned!(ty.span() => <#ty as ::core::default::Default>::default()),
                Role::Child { .. } => {
                    let (number, name) = (roles.len() as u32, &field.name);
                    roles.push(field.child_table());
                    quote!(<#ty>::new(#number, #name))
                }
                Role::Modulates { child, .. } => {
                    let number = ports.add(field.port_table(position(&child.value())));
                    port(number, &format!("{}.{}", child.value(), field.name))
                }
                Role::List { .. } => {
                    lists.push(field.list_table());
                    list_members.push(member);
                    quote!(<#ty>::new())
                }
                Role::Bundle => {
                    let number = ports.add_bundle(ty);
                    // SAFETY (of the generated code): its tables begin with that number.
                    quote!(unsafe { <#ty as derived::PortBundle>::build(ports, first + #number) })
                }
                Role::Import
                | Role::Export { .. }
                | Role::Modulation { .. }
                | Role::Command { .. }
                | Role::Actuator => port(ports.add(field.port_table(None)), &field.name),
            };
            values.push(quote!(#member: #value));
        }
        ports.end_run();
        Self {
            ports,
            roles,
            lists,
            list_members,
            build: quote!(Self { #(#values),* }),
        }
    }
}

impl<'f> Ports<'f> {
    /// Adds an own port and returns its number.
    fn add(&mut self, table: TokenStream) -> TokenStream {
        let number = self.next();
        self.run.push(table);
        self.own += 1;
        number
    }

    /// Adds the ports of a bundle and returns the number of the first.
    fn add_bundle(&mut self, ty: &'f Type) -> TokenStream {
        let number = self.next();
        self.end_run();
        self.parts
            .push(quote_spanned!(ty.span() => <#ty as derived::PortBundle>::PORTS));
        self.bundles.push(ty);
        number
    }

    fn end_run(&mut self) {
        let run = std::mem::take(&mut self.run);
        if !run.is_empty() {
            self.parts.push(quote!(&[#(#run),*]));
        }
    }

    fn next(&self) -> TokenStream {
        let count = self.count();
        quote!((#count) as u32)
    }

    /// Generates the number of all ports.
    pub(super) fn count(&self) -> TokenStream {
        let (own, bundles) = (self.own, &self.bundles);
        quote!(#own #(+ <#bundles as derived::PortBundle>::PORTS.len())*)
    }

    /// Generates the tables, in parts.
    pub(super) fn tables(&self) -> TokenStream {
        let parts = &self.parts;
        quote!(&[#(#parts),*])
    }
}
