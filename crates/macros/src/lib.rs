//! The derive macros of values and schemas. They write tables and no behaviour; what a table needs done is ordinary code in
//! `jde-types` and `jde-schema`.

mod choice;
mod schema;
#[cfg(test)]
mod tests;
mod text;
mod value;

use proc_macro::TokenStream;
use quote::quote;
use syn::{DeriveInput, Error, parse_macro_input};

/// Makes a structure a value that schemas can share; see the trait of the same name.
///
/// On the structure: `#[value(name = "package/msg/Name")]`, by default the crate's and the structure's. On a field:
/// `#[value(unit = "m")]`. Comments become the descriptions that tools show.
#[proc_macro_derive(Value, attributes(value))]
pub fn derive_value(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    value::derive(&input, &quote!(::jde_types::derived))
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

/// [`Value`](macro@Value) for those who depend on `jde-schema` alone, which exports it under that name.
#[proc_macro_derive(AuthorsValue, attributes(value))]
pub fn derive_authors_value(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    value::derive(&input, &quote!(::jde_schema::types::derived))
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

/// Makes an enumeration something that a modulation may be: one of several, by name.
///
/// It is `#[repr(u8)]`, and its variants hold nothing and have no numbers of their own. A variant `LeftTurn` is called `left-turn` in
/// application files and tools.
#[proc_macro_derive(Choice)]
pub fn derive_choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    choice::derive(&input, &quote!(::jde_types::derived))
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

/// [`Choice`](macro@Choice) for those who depend on `jde-schema` alone, which exports it under that name.
#[proc_macro_derive(AuthorsChoice)]
pub fn derive_authors_choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    choice::derive(&input, &quote!(::jde_schema::types::derived))
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

/// Makes the table of a schema type from a structure.
///
/// On the structure, `#[schema(...)]`: one of `motor`, `perceptive`, `driver`; `period = "75ms"`; perhaps `name = "..."` (by
/// default the structure's, `StopNow` as `stop-now`) and `budget = "5ms"` (by default the period).
///
/// On its fields, at most one of
///
/// | attribute | type | options |
/// |---|---|---|
/// | `#[import]` | `Import<T>` | `trigger`, `optional`, `unit`, `name` |
/// | `#[export]` | `Export<T>` | `unit`, `name` |
/// | `#[modulation(default = ...)]` | `Modulation<T>` | `unit`, `min`, `max`, `fixed`, `name` |
/// | `#[command(neutral = ..., validity = "500ms")]` | `Command<T>` | `unit`, `name` |
/// | `#[actuator]` | `Actuator<T>` | `optional`, `unit`, `name` |
/// | `#[child(group = "...")]`, `#[child(perceptive)]` | `Child` | `optional`, `name` |
/// | `#[child(group = "...")]`, the last of all | `Children` | `name` |
/// | `#[modulates(child = "...", name = "...")]` | `Modulates<T>` | `optional`, `unit` |
///
/// A name is by default the field's. Defaults and neutral values are constants of type `T`; for a `Text<N>` a literal will do.
/// A modulation is a value, a `bool`, or an enumeration with `#[derive(Choice)]`; its default is a constant within its `min` and `max`.
/// One that is `fixed` is taken when the schema awakes and kept until it sleeps. One with `unit = "path"` holds a path, which the application may give relative to itself; with `unit = "file"` that of a file which has to be there before the application starts. Other units are SI's
/// (docs/schemas.md).
/// Any other field is the schema's own memory and begins with its `Default`. Comments become the descriptions that tools show.
#[proc_macro_derive(
    Describe,
    attributes(schema, import, export, modulation, command, actuator, child, modulates)
)]
pub fn derive_describe(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    schema::derive(&input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}
