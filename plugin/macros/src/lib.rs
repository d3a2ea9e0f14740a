//! The derive macros of values and schemas. They generate tables and no behaviour: the functions behind the
//! tables are ordinary code in `jde-types` and `jde-schema`.

mod choice;
mod schema;
#[cfg(test)]
mod tests;
mod text;
mod value;

use proc_macro::TokenStream;
use proc_macro2::TokenStream as TokenStream2;
use quote::quote;
use syn::{DeriveInput, Result, parse_macro_input};

/// Makes a structure a value that schemas can share. See the trait of the same name.
///
/// On the structure: `#[value(name = "package/msg/Name")]`; the default is the crate's and the structure's
/// name. On a field: `#[value(unit = "m")]`. Doc comments become the descriptions that tools show.
#[proc_macro_derive(Value, attributes(value))]
pub fn derive_value(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = quote!(::jde_types::derived);
    let placeholder = value::placeholder(&input.ident, &derived);
    or_placeholder(value::derive(&input, &derived), &input, placeholder)
}

/// [`Value`](macro@Value) for crates that depend on `jde-schema` alone, which exports it under that name.
#[proc_macro_derive(AuthorsValue, attributes(value))]
pub fn derive_authors_value(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = quote!(::jde_schema::types::derived);
    let placeholder = value::placeholder(&input.ident, &derived);
    or_placeholder(value::derive(&input, &derived), &input, placeholder)
}

/// Makes an enumeration a type for modulations: a choice of one among several names.
///
/// The enumeration must be `#[repr(u8)]`. Its variants must have no fields and no explicit numbers. A variant
/// `LeftTurn` has the name `left-turn` in application files and tools.
#[proc_macro_derive(Choice)]
pub fn derive_choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = quote!(::jde_types::derived);
    let placeholder = value::placeholder(&input.ident, &derived);
    or_placeholder(choice::derive(&input, &derived), &input, placeholder)
}

/// [`Choice`](macro@Choice) for crates that depend on `jde-schema` alone, which exports it under that name.
#[proc_macro_derive(AuthorsChoice)]
pub fn derive_authors_choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = quote!(::jde_schema::types::derived);
    let placeholder = value::placeholder(&input.ident, &derived);
    or_placeholder(choice::derive(&input, &derived), &input, placeholder)
}

/// Generates the table of a schema type from a structure.
///
/// On the structure, `#[schema(...)]`: one of `motor`, `perceptive`, `driver`; `period = "75ms"`; optionally
/// `name = "..."` (the default is the structure's name, `StopNow` as `stop-now`) and `budget = "5ms"` (the
/// default is the period).
///
/// On each field, at most one of
///
/// | attribute | type | options |
/// |---|---|---|
/// | `#[import]` | `Import<T>` | `trigger`, `optional`, `unit`, `name` |
/// | `#[export]` | `Export<T>` | `lasting` or `validity`, `unit`, `name` |
/// | `#[modulation(default = ...)]` | `Modulation<T>` | `unit`, `min`, `max`, `fixed`, `mount`, `margin`, `limit`, `name`, `was` |
/// | `#[command(neutral = ..., validity = "500ms")]` | `Command<T>` | `trigger`, `unit`, `name` |
/// | `#[actuator]` | `Actuator<T>` | `optional`, `unit`, `name` |
/// | `#[child(group = "...")]`, `#[child(perceptive)]` | `Child` | `optional`, `name` |
/// | `#[child(group = "...")]`, the last of all | `Children` | `name` |
/// | `#[modulates(child = "...", name = "...")]` | `Modulates<T>` | `optional`, `unit` |
/// | `#[ports]` | a bundle, with [`PortBundle`](macro@PortBundle) | |
///
/// The default name is the field's. Default and neutral values are constants of type `T`. A text literal is
/// accepted for a `Text<N>`. A modulation is a value, a `bool`, or an enumeration with `#[derive(Choice)]`.
/// Its default must be within its `min` and `max`. A `fixed` modulation is read when the schema awakes and
/// kept until it sleeps. `was = "..."` is the name that it had in the version before: files and options with that
/// name are read, with a warning. `mount`, `margin` and `limit` say what a value is that several schemas must agree on, and
/// `jde check` compares it (docs/applications.md).
///
/// A value of an export is valid for three periods that the application states, unless `validity = "500ms"` states
/// another time. A `lasting` value is valid until it is replaced or retracted (R19).
///
/// `unit = "path"` marks a path, which the application may give relative to its own file. `unit = "file"`
/// marks such a path of a file that must exist before the application starts. `unit = "model"` marks a path if the
/// text ends in `.toml`, and otherwise a name of something that the plugin has. Other units are those of SI
/// (docs/schemas.md).
///
/// Any other field is the schema's own memory and starts with its `Default`. Doc comments become the
/// descriptions that tools show.
#[proc_macro_derive(
    Describe,
    attributes(
        schema, import, export, modulation, command, actuator, child, modulates, imports, exports, commands,
        ports
    )
)]
pub fn derive_describe(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    or_placeholder(schema::derive(&input), &input, schema::placeholder(&input.ident))
}

/// Makes a structure a bundle of ports that several types of schema have.
///
/// Its fields are imports, exports, modulations, commands and actuators, with the attributes that they have in a
/// [schema](macro@Describe), and other bundles. A schema has the ports of a bundle, under their own names, in the
/// place of a field `#[ports] limits: Limits`. A name may occur once in a schema, as without bundles.
#[proc_macro_derive(PortBundle, attributes(import, export, modulation, command, actuator, ports))]
pub fn derive_port_bundle(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let placeholder = schema::bundle::placeholder(&input.ident);
    or_placeholder(schema::bundle::derive(&input), &input, placeholder)
}

/// Returns the generated code, or an error and a placeholder. The placeholder implements the trait, so that
/// the compiler does not also report a missing implementation. A type with parameters has none, because it
/// may not be `'static`.
fn or_placeholder(
    generated: Result<TokenStream2>,
    input: &DeriveInput,
    placeholder: TokenStream2,
) -> TokenStream {
    let code = generated.unwrap_or_else(|error| {
        let mut code = error.into_compile_error();
        if input.generics.params.is_empty() {
            code.extend(placeholder);
        }
        code
    });
    code.into()
}
