//! `#[derive(Describe)]`: the table of a schema type, from its structure.

mod about;
pub(crate) mod bundle;
mod field;
mod members;
mod options;

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result};

use self::about::{About, Kind};
use self::field::{Role, SchemaField};
use self::members::Members;
use crate::text::c;

/// Generates the implementation of `Describe` for `input`.
pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let fields = fields(input, "schema")?;
    let about = About::of(input)?;
    let fields = fields.iter().map(SchemaField::of).collect::<Result<Vec<_>>>()?;
    check(&about, &fields)?;
    Ok(implementation(&input.ident, &about, &Members::of(&fields)))
}

/// Returns the fields of a schema or a bundle.
pub(super) fn fields<'i>(input: &'i DeriveInput, what: &str) -> Result<&'i Fields> {
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(
            &input.ident,
            format!("a {what} is a structure; its fields are its ports"),
        ));
    };
    if let Fields::Unnamed(fields) = &data.fields {
        return Err(Error::new_spanned(
            fields,
            format!("a {what} has named fields, because its ports have names"),
        ));
    }
    if !input.generics.params.is_empty() {
        return Err(Error::new_spanned(
            &input.generics,
            format!("a {what} has no generic parameters, because the values of its ports have one type each"),
        ));
    }
    Ok(&data.fields)
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
    let mut members = Members::of(&[]);
    members.build = quote!(::core::unreachable!());
    implementation(ident, &about, &members)
}

fn implementation(ident: &Ident, about: &About, members: &Members<'_>) -> TokenStream {
    let kind = about.kind.constant();
    let (name, doc) = (c(&about.name), c(&about.doc));
    let (period, budget) = (about.period_ns, about.budget_ns);
    let Members {
        ports,
        roles,
        lists,
        list_members,
        build,
    } = members;
    let (tables, count) = (ports.tables(), ports.count());
    let list_count = lists.len();
    let numbers = 0..list_count as u32;
    quote! {
        const _: () = {
            use ::jde_schema::derived;
            #[allow(unused_imports, reason = "only schemas without an arbitration or an ability use it")]
            use derived::Without as _;

            static PORTS: [derived::raw::Port; #count] = derived::ports(#kind, #tables);
            const CHILDREN: &[derived::raw::Child] = &[#(#roles),*];
            static LISTS: [derived::raw::PortList; #list_count] = [#(#lists),*];

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
                    #[allow(unused_variables, reason = "only ports use it")]
                    let (ports, first): (&'static [derived::raw::Port], u32) = (&PORTS, 0);
                    #build
                }

                unsafe fn add_listed(&mut self, port: &derived::raw::ListedPort) {
                    match port.list {
                        // SAFETY: the caller's; the lists have the order of their tables.
                        #(#numbers => unsafe { self.#list_members.add(&PORTS, port) },)*
                        _ => {}
                    }
                }
            }
        };
    }
}

/// Refuses mistakes that the host would otherwise refuse at loading.
fn check(about: &About, fields: &[SchemaField]) -> Result<()> {
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
            Role::Actuator if about.kind != Kind::Motor => {
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
            | Role::Bundle
            | Role::Import
            | Role::Export { .. }
            | Role::Modulation { .. }
            | Role::Command { .. }
            | Role::Actuator
            | Role::Child { .. }
            | Role::List { .. } => {}
        }
    }
    check_names(fields)
}

/// Refuses names that the host gives another meaning, and two ports of one name. The names in bundles are compared
/// when the tables are joined.
fn check_names(fields: &[SchemaField]) -> Result<()> {
    let mut seen: Vec<(String, &SchemaField)> = Vec::new();
    for field in fields {
        let wrong = |message: String| Err(Error::new(field.span, message));
        match &field.role {
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
            _ => {}
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
