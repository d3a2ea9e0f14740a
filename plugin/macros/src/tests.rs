//! Every mistake that the macros detect, its message, and the place to which the message points.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Result, parse_str};

fn schema(source: &str) -> Result<TokenStream> {
    crate::schema::derive(&parse_str::<DeriveInput>(source)?)
}

fn value(source: &str) -> Result<TokenStream> {
    crate::value::derive(&parse_str::<DeriveInput>(source)?, &quote!(derived))
}

/// Checks the message for `source`, in which `‹` and `›` enclose the mistake.
#[track_caller]
fn check(derive: fn(&str) -> Result<TokenStream>, source: &str, message: &str) {
    let mistake = source.split(['‹', '›']).nth(1).unwrap_or_default();
    let error = match derive(&source.replace(['‹', '›'], "")) {
        Err(error) => error,
        Ok(_) => panic!("accepted: {source}"),
    };
    let text = error.to_string();
    assert!(text.contains(message), "the message is: {text}");
    assert_eq!(
        error.span().source_text().unwrap_or_default(),
        mistake,
        "for: {text}"
    );
}

/// As above, for one field of a schema of this kind.
#[track_caller]
fn check_field(kind: &str, fields: &str, message: &str) {
    let source = format!("#[schema({kind}, period = \"1s\")] struct Stop {{ {fields} }}");
    check(schema, &source, message);
}

#[test]
fn a_schema_declares_its_kind_and_period() {
    check(schema, "struct ‹Stop› {}", "state the kind of the schema");
    check(
        schema,
        "‹#[schema(motor)]› struct Stop {}",
        "state the default period",
    );
    check(
        schema,
        "#[schema(motor, ‹driver›)] struct Stop {}",
        "exactly one kind",
    );
    check(
        schema,
        "#[schema(motor, ‹perod› = \"1s\")] struct Stop {}",
        "unknown option",
    );
    check(
        schema,
        "#[schema(motor, period = ‹\"75\"›)] struct Stop {}",
        "`75` is not a duration",
    );
    check(
        schema,
        "#[schema(motor, period = ‹\"0s\"›)] struct Stop {}",
        "at least 1 ns",
    );
    check(
        schema,
        "#[schema(motor, period = \"1s\", name = ‹\"a b\"›)] struct Stop {}",
        "`a b` is not a name",
    );
}

#[test]
fn a_schema_is_a_plain_structure_with_named_fields() {
    check(
        schema,
        "#[schema(motor, period = \"1s\")] enum ‹Stop› {}",
        "a schema is a structure",
    );
    check(
        schema,
        "#[schema(motor, period = \"1s\")] struct Stop‹(u8)›;",
        "named fields",
    );
    check(
        schema,
        "#[schema(motor, period = \"1s\")] struct Stop‹<T>› { a: T }",
        "no generic parameters",
    );
}

#[test]
fn attributes_must_match_the_types_of_their_fields() {
    check_field(
        "motor",
        "#[import] a: ‹Export<f64>›",
        "has the type `Import<...>`",
    );
    check_field(
        "motor",
        "#[child(group = \"g\")] a: ‹Import<f64>›",
        "has the type `Child`",
    );
    check_field("motor", "a: ‹Import<f64>›", "needs the attribute #[import]");
    check_field("motor", "#[import] a: ‹Import›", "state the type of the value");
    check_field("motor", "#[import] ‹#[export]› a: Import<f64>", "one attribute");
    check_field(
        "motor",
        "#[import(‹triger›)] a: Import<f64>",
        "expected one of trigger, optional",
    );
    check_field("motor", "#[import(trigger, ‹trigger›)] a: Import<f64>", "twice");
    check_field(
        "motor",
        "#[import(name = ‹\"\"›)] a: Import<f64>",
        "is not a name",
    );
}

#[test]
fn modulations_and_commands_need_initial_values() {
    check_field("motor", "‹#[modulation]› a: Modulation<f64>", "default = ...");
    check_field(
        "driver",
        "‹#[command(validity = \"1s\")]› a: Command<f64>",
        "neutral = ...",
    );
    check_field(
        "driver",
        "‹#[command(neutral = 0.0)]› a: Command<f64>",
        "validity = \"500ms\"",
    );
}

#[test]
fn unknown_units_are_refused() {
    let message = "`metre` is no unit; use m, km";
    check_field(
        "motor",
        "#[modulation(default = 0.0, unit = ‹\"metre\"›)] a: Modulation<f64>",
        message,
    );
    check_field("motor", "#[import(unit = ‹\"metre\"›)] a: Import<f64>", message);
    check(
        value,
        "#[repr(C)] struct Scan { #[value(unit = ‹\"metre\"›)] a: u8 }",
        message,
    );
}

#[test]
fn a_choice_is_an_enumeration_of_bytes() {
    fn choice(source: &str) -> Result<TokenStream> {
        crate::choice::derive(&parse_str::<DeriveInput>(source)?, &quote!(derived))
    }
    check(
        choice,
        "#[repr(u8)] struct ‹Gait› {}",
        "a choice is an enumeration",
    );
    check(choice, "enum ‹Gait› { Slow }", "add `#[repr(u8)]`");
    check(choice, "#[repr(u8)] enum ‹Gait› {}", "at least one variant");
    check(choice, "#[repr(u8)] enum Gait { Slow‹(u8)› }", "no fields");
    check(choice, "#[repr(u8)] enum Gait { Slow = ‹3› }", "omit the number");
    check(
        choice,
        "#[repr(u8)] enum Gait‹<T>› { Slow }",
        "no generic parameters",
    );
    assert!(choice("#[repr(u8)] enum Gait { Slow, Fast }").is_ok());
}

#[test]
fn each_kind_has_only_its_own_ports() {
    check_field(
        "motor",
        "#[command(neutral = 0.0, validity = \"1s\")] ‹a›: Command<f64>",
        "only a driver",
    );
    check_field("driver", "#[actuator] ‹a›: Actuator<f64>", "only a motor schema");
    check_field(
        "perceptive",
        "#[child(group = \"g\")] ‹a›: Child",
        "only a motor schema has motor children",
    );
}

#[test]
fn a_bundle_has_ports_of_unique_names() {
    fn bundle(source: &str) -> Result<TokenStream> {
        crate::schema::bundle::derive(&parse_str::<DeriveInput>(source)?)
    }
    let only_ports = "a bundle has imports, exports, modulations, commands, actuators and other bundles only";
    check(bundle, "struct Limits { ‹seen›: u8 }", only_ports);
    check(
        bundle,
        "struct Limits { #[child(perceptive)] ‹map›: Child }",
        only_ports,
    );
    check(bundle, "enum ‹Limits› {}", "a bundle is a structure");
    check(bundle, "struct Limits‹<T>› { a: T }", "no generic parameters");
    check(
        bundle,
        "struct Limits { #[export] a: Export<f64>, #[modulation(default = 0.0, name = \"a\")] ‹b›: Modulation<f64> }",
        "two have the name `a`",
    );
    check(
        bundle,
        "struct Limits { #[modulation(default = 0.0)] ‹children›: Modulation<f64> }",
        "is reserved in application files",
    );
    check_field("motor", "#[ports] ‹#[import]› a: Import<f64>", "one attribute");
    check_field(
        "motor",
        "#[ports‹(›x)] a: Limits",
        "unexpected token in attribute",
    );
    check_field(
        "motor",
        "#[modulation(default = 0.0, was = ‹\"a b\"›)] a: Modulation<f64>",
        "`a b` is not a name",
    );
    assert!(bundle("struct Limits { #[import] a: Import<f64>, #[ports] more: More }").is_ok());
}

#[test]
fn a_child_competes_in_a_group_or_is_perceptive() {
    check_field("motor", "‹#[child]› a: Child", "competes in a group");
    check_field(
        "motor",
        "‹#[child(group = \"g\", perceptive)]› a: Child",
        "competes in a group",
    );
    check_field(
        "motor",
        "#[child(group = \"g\", ‹perceptive›)] a: Children",
        "expected one of group, name",
    );
    check_field("motor", "a: ‹Children›", "needs the attribute #[child]");
    check_field(
        "motor",
        "#[child(group = \"g\")] ‹a›: Children, #[child(group = \"g\")] b: Child",
        "`Children` must be last",
    );
    check_field(
        "motor",
        "#[child(group = \"g\")] a: Children, #[modulates(child = ‹\"a\"›)] b: Modulates<f64>",
        "there is no child `a`",
    );
    check_field("motor", "‹#[modulates]› a: Modulates<f64>", "state the child");
    check_field(
        "motor",
        "#[child(perceptive)] cruise: Child, #[modulates(child = ‹\"cruse\"›)] a: Modulates<f64>",
        "there is no child `cruse` (children: cruise)",
    );
}

#[test]
fn names_are_unique_within_their_name_space() {
    check_field(
        "motor",
        "#[import] a: Import<f64>, #[import(name = \"a\")] ‹b›: Import<f64>",
        "two have the name `a`",
    );
    check_field(
        "motor",
        "#[export] a: Export<f64>, #[modulation(default = 0.0, name = \"a\")] ‹b›: Modulation<f64>",
        "two have the name `a`",
    );
    check_field(
        "motor",
        "#[modulation(default = 0.0)] ‹children›: Modulation<f64>",
        "is reserved in application files",
    );
    check_field(
        "motor",
        "#[export] ‹period›: Export<f64>",
        "already has a variable `period`",
    );
    check_field(
        "driver",
        "#[command(neutral = 0.0, validity = \"1s\")] ‹period›: Command<f64>",
        "already has a variable `period`",
    );
    assert!(schema("#[schema(motor, period = \"1s\")] struct Stop { #[import] a: Import<f64>, #[export(name = \"a\")] b: Export<f64> }").is_ok());
}

#[test]
fn a_value_is_a_plain_c_structure_with_named_fields() {
    check(value, "struct ‹Scan› { a: u8 }", "add `#[repr(C)]`");
    check(
        value,
        "#[repr(C, ‹packed›)] struct Scan { a: u8 }",
        "only `#[repr(C)]`",
    );
    check(value, "#[repr(C)] enum ‹Scan› { A }", "a value is a structure");
    check(value, "#[repr(C)] struct ‹Scan›(u8);", "named fields");
    check(
        value,
        "#[repr(C)] struct Scan‹<T>› { a: T }",
        "no generic parameters",
    );
    check(
        value,
        "#[repr(C)] struct Scan { #[value(‹name› = \"x\")] a: u8 }",
        "only `unit = \"...\"`",
    );
}

#[test]
fn type_names_become_kebab_case() {
    for (name, kebab) in [
        ("Stop", "stop"),
        ("StopNow", "stop-now"),
        ("Hijo1", "hijo1"),
        ("VFFNear", "vff-near"),
    ] {
        assert_eq!(crate::text::kebab(name), kebab);
    }
}

#[test]
fn comments_become_descriptions_line_by_line() {
    let item: DeriveInput =
        syn::parse_quote! { #[doc = " One."] #[doc = ""] #[doc = "  - two, [`B`]"] struct A; };
    assert_eq!(crate::text::doc(&item.attrs), "One.\n\n - two, `B`");
}
