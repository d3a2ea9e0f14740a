//! `#[derive(Describe)]`: the table of a schema type, from its structure.

mod about;
mod field;
mod options;

use proc_macro2::{Ident, TokenStream};
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Error, Fields, Result};

use self::about::{About, Kind};
use self::field::{Field, Role};
use crate::text::c;

/// Generates the implementation of `Describe` for `input`.
pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let ident = &input.ident;
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(
            ident,
            "a schema is a structure; its fields are its ports and its memory",
        ));
    };
    if let Fields::Unnamed(fields) = &data.fields {
        return Err(Error::new_spanned(
            fields,
            "a schema has named fields, because its ports have names",
        ));
    }
    if !input.generics.params.is_empty() {
        return Err(Error::new_spanned(
            &input.generics,
            "a schema has no generic parameters, because each type has one name",
        ));
    }
    let about = About::of(input)?;
    let fields = data.fields.iter().map(Field::of).collect::<Result<Vec<_>>>()?;
    check(&about, &fields)?;

    let children: Vec<&Field> = fields.iter().filter(|field| field.is_child()).collect();
    let position = |name: &str| children.iter().position(|child| child.name == name);
    let mut ports = Vec::new();
    let mut roles = Vec::new();
    let mut values = Vec::new();
    let mut lists = Vec::new();
    let mut list_members = Vec::new();
    for field in &fields {
        let (member, ty) = (&field.member, &field.ty);
        let value = match &field.role {
            Role::Memory => quote_spanned!(ty.span() => <#ty as ::core::default::Default>::default()),
            Role::Child { .. } => {
                let (number, name) = (roles.len() as u32, &field.name);
                roles.push(field.child_table());
                quote!(<#ty>::new(#number, #name))
            }
            Role::Modulates { child, .. } => {
                let number = ports.len() as u32;
                let shown = format!("{}.{}", child.value(), field.name);
                ports.push(field.port_table(position(&child.value())));
                // SAFETY (of the generated code): the table above has this number, this kind and this type.
                quote!(unsafe { <#ty>::new(&PORTS, #number, #shown) })
            }
            Role::List { .. } => {
                lists.push(field.list_table());
                list_members.push(member);
                quote!(<#ty>::new())
            }
            Role::Import { .. }
            | Role::Export { .. }
            | Role::Modulation { .. }
            | Role::Command { .. }
            | Role::Actuator { .. } => {
                let (number, name) = (ports.len() as u32, &field.name);
                ports.push(field.port_table(None));
                // SAFETY (of the generated code): the table above has this number, this kind and this type.
                quote!(unsafe { <#ty>::new(&PORTS, #number, #name) })
            }
        };
        values.push(quote!(#member: #value));
    }

    Ok(implementation(
        ident,
        &about,
        &ports,
        &roles,
        &Lists {
            tables: &lists,
            members: &list_members,
        },
        &quote!(Self { #(#values),* }),
    ))
}

/// Generates an implementation of `Describe` without ports, for a structure with a mistake.
pub(crate) fn placeholder(ident: &Ident) -> TokenStream {
    let about = About {
        name: String::new(),
        doc: String::new(),
        kind: Kind::Motor,
        period_ns: 0,
        budget_ns: 0,
    };
    let none = Lists {
        tables: &[],
        members: &[],
    };
    implementation(ident, &about, &[], &[], &none, &quote!(::core::unreachable!()))
}

/// The lists of ports: their tables and the fields that hold them.
struct Lists<'f> {
    tables: &'f [TokenStream],
    members: &'f [&'f Ident],
}

fn implementation(
    ident: &Ident,
    about: &About,
    ports: &[TokenStream],
    roles: &[TokenStream],
    lists: &Lists<'_>,
    build: &TokenStream,
) -> TokenStream {
    let kind = about.kind.constant();
    let (name, doc) = (c(&about.name), c(&about.doc));
    let (period, budget) = (about.period_ns, about.budget_ns);
    let count = ports.len();
    let Lists { tables, members } = lists;
    let list_count = tables.len();
    let numbers = 0..list_count as u32;
    quote! {
        const _: () = {
            use ::jde_schema::derived;
            #[allow(unused_imports, reason = "only schemas without an arbitration or an ability use it")]
            use derived::Without as _;

            static PORTS: [derived::raw::Port; #count] = [#(#ports),*];
            const CHILDREN: &[derived::raw::Child] = &[#(#roles),*];
            static LISTS: [derived::raw::PortList; #list_count] = [#(#tables),*];

            // A guard whose state is no export fails here.
            const _: Option<derived::raw::Guard> = <#ident as derived::Describe>::GUARD;

            // SAFETY: tables and values are generated from the same fields in the same order, and the static
            // is this type's alone.
            unsafe impl derived::Describe for #ident {
                const TABLE: derived::raw::Schema = derived::schema::<#ident>(
                    derived::About {
                        name: #name,
                        doc: #doc,
                        kind: #kind,
                        period_ns: #period,
                        budget_ns: #budget,
                    },
                    &PORTS,
                    CHILDREN,
                    derived::Own::<#ident>::ARBITRATE,
                );
                const PANEL: Option<derived::raw::Panel> = derived::Own::<#ident>::PANEL;
                const STATE: Option<derived::raw::State> = derived::Own::<#ident>::STATE;
                const INSPECT: Option<derived::raw::Inspect> = derived::Own::<#ident>::INSPECT;
                const GUARD: Option<derived::raw::Guard> = derived::Own::<#ident>::GUARD;
                const LISTS: Option<derived::raw::Lists> = derived::lists::<#ident>(&LISTS);
                const HAS_ABILITY: bool = Self::PANEL.is_some()
                    || Self::LISTS.is_some()
                    || Self::STATE.is_some()
                    || Self::INSPECT.is_some()
                    || derived::Own::<#ident>::IS_GUARD;

                unsafe fn build() -> Self {
                    #build
                }

                unsafe fn add_listed(&mut self, port: &derived::raw::ListedPort) {
                    match port.list {
                        // SAFETY: the caller's; the lists have the order of their tables.
                        #(#numbers => unsafe { self.#members.add(&PORTS, port) },)*
                        _ => {}
                    }
                }
            }
        };
    }
}

/// Refuses mistakes that the host would otherwise refuse at loading.
fn check(about: &About, fields: &[Field]) -> Result<()> {
    let mut seen: Vec<(String, &Field)> = Vec::new();
    let last = fields.iter().rfind(|field| field.is_child());
    for field in fields {
        let wrong = |message: String| Err(Error::new(field.span, message));
        match &field.role {
            Role::Command { .. } if about.kind != Kind::Driver => {
                return wrong(
                    "only a driver takes commands; a motor schema writes them through #[actuator]".into(),
                );
            }
            Role::List { validity_ns, .. } if *validity_ns > 0 && about.kind != Kind::Driver => {
                return wrong("only a driver has lists of commands".into());
            }
            Role::Actuator { .. } if about.kind != Kind::Motor => {
                return wrong("only a motor schema commands actuators".into());
            }
            Role::Child { group: Some(_), .. } if about.kind != Kind::Motor => {
                return wrong(
                    "only a motor schema has motor children; a perceptive one is #[child(perceptive)]".into(),
                );
            }
            Role::Child { many: true, .. } if !last.is_some_and(|last| std::ptr::eq(last, field)) => {
                return wrong("`Children` must be last: the application numbers them from there on".into());
            }
            Role::Modulation { .. } if jde_abi::read::RESERVED.contains(&field.name.as_str()) => {
                return wrong(format!(
                    "`{}` is reserved in application files; choose another name for this modulation",
                    field.name
                ));
            }
            Role::Export { .. } | Role::Command { .. } if field.name == jde_abi::read::PERIOD => {
                return wrong(String::from(
                    "every schema already has a variable `period`; choose another name",
                ));
            }
            Role::Modulates { child, .. } => {
                let known: Vec<&str> = fields
                    .iter()
                    .filter(|field| matches!(field.role, Role::Child { many: false, .. }))
                    .map(|field| field.name.as_str())
                    .collect();
                if !known.contains(&child.value().as_str()) {
                    let known = if known.is_empty() {
                        "it has no children".to_owned()
                    } else {
                        format!("children: {}", known.join(", "))
                    };
                    return Err(Error::new(
                        child.span(),
                        format!("there is no child `{}` ({known})", child.value()),
                    ));
                }
            }
            Role::Memory
            | Role::Import { .. }
            | Role::Export { .. }
            | Role::Modulation { .. }
            | Role::Command { .. }
            | Role::Actuator { .. }
            | Role::Child { .. }
            | Role::List { .. } => {}
        }
        let Some(space) = field.name_space() else { continue };
        if let Some((_, first)) = seen
            .iter()
            .find(|(other, first)| *other == space && first.name == field.name)
        {
            let mut error = Error::new(field.span, format!("two have the name `{}`", field.name));
            error.combine(Error::new(first.span, "the other one"));
            return Err(error);
        }
        seen.push((space, field));
    }
    Ok(())
}
