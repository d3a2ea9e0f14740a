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

/// Checks the message for `source`, in which `‹` and `›` enclose the place of the mistake.
#[track_caller]
fn check(derive: fn(&str) -> Result<TokenStream>, source: &str, words: &str) {
    let place = source.split(['‹', '›']).nth(1).unwrap_or_default();
    let error = match derive(&source.replace(['‹', '›'], "")) {
        Err(error) => error,
        Ok(_) => panic!("accepted: {source}"),
    };
    let said = error.to_string();
    assert!(said.contains(words), "it says: {said}");
    assert_eq!(
        error.span().source_text().unwrap_or_default(),
        place,
        "for: {said}"
    );
}

/// As above, for one field of a schema of this kind.
#[track_caller]
fn check_field(kind: &str, fields: &str, words: &str) {
    let source = format!("#[schema({kind}, period = \"1s\")] struct Stop {{ {fields} }}");
    check(schema, &source, words);
}

#[test]
fn a_schema_says_its_kind_and_period() {
    check(schema, "struct ‹Stop› {}", "say what kind of schema this is");
    check(
        schema,
        "‹#[schema(motor)]› struct Stop {}",
        "say how often it iterates",
    );
    check(schema, "#[schema(motor, ‹driver›)] struct Stop {}", "of one kind");
    check(
        schema,
        "#[schema(motor, ‹perod› = \"1s\")] struct Stop {}",
        "unknown option",
    );
    check(
        schema,
        "#[schema(motor, period = ‹\"75\"›)] struct Stop {}",
        "`75` is no time",
    );
    check(
        schema,
        "#[schema(motor, period = ‹\"0s\"›)] struct Stop {}",
        "at least 1 ns",
    );
    check(
        schema,
        "#[schema(motor, period = \"1s\", name = ‹\"a b\"›)] struct Stop {}",
        "`a b` is no name",
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
fn attributes_and_types_of_fields_agree() {
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
    check_field("motor", "#[import] a: ‹Import›", "say what type of value");
    check_field("motor", "#[import] ‹#[export]› a: Import<f64>", "one attribute");
    check_field(
        "motor",
        "#[import(‹triger›)] a: Import<f64>",
        "here may stand trigger, optional",
    );
    check_field("motor", "#[import(trigger, ‹trigger›)] a: Import<f64>", "twice");
    check_field("motor", "#[import(name = ‹\"\"›)] a: Import<f64>", "is no name");
}

#[test]
fn modulations_and_commands_have_values_from_the_start() {
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
fn units_are_units() {
    let words = "`metre` is no unit; use m, km";
    check_field(
        "motor",
        "#[modulation(default = 0.0, unit = ‹\"metre\"›)] a: Modulation<f64>",
        words,
    );
    check_field("motor", "#[import(unit = ‹\"metre\"›)] a: Import<f64>", words);
    check(
        value,
        "#[repr(C)] struct Scan { #[value(unit = ‹\"metre\"›)] a: u8 }",
        words,
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
    check(choice, "#[repr(u8)] enum ‹Gait› {}", "something to choose");
    check(choice, "#[repr(u8)] enum Gait { Slow‹(u8)› }", "holds nothing");
    check(
        choice,
        "#[repr(u8)] enum Gait { Slow = ‹3› }",
        "leave the number out",
    );
    check(
        choice,
        "#[repr(u8)] enum Gait‹<T>› { Slow }",
        "no generic parameters",
    );
    assert!(choice("#[repr(u8)] enum Gait { Slow, Fast }").is_ok());
}

#[test]
fn kinds_keep_to_what_they_may_do() {
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
fn children_compete_in_a_group_or_are_perceptive() {
    check_field("motor", "‹#[child]› a: Child", "competes in a group");
    check_field(
        "motor",
        "‹#[child(group = \"g\", perceptive)]› a: Child",
        "competes in a group",
    );
    check_field(
        "motor",
        "#[child(group = \"g\", ‹perceptive›)] a: Children",
        "here may stand group, name",
    );
    check_field("motor", "a: ‹Children›", "needs the attribute #[child]");
    check_field(
        "motor",
        "#[child(group = \"g\")] ‹a›: Children, #[child(group = \"g\")] b: Child",
        "`Children` come last",
    );
    check_field(
        "motor",
        "#[child(group = \"g\")] a: Children, #[modulates(child = ‹\"a\"›)] b: Modulates<f64>",
        "there is no child `a` here",
    );
    check_field("motor", "‹#[modulates]› a: Modulates<f64>", "say which child's");
    check_field(
        "motor",
        "#[child(perceptive)] cruise: Child, #[modulates(child = ‹\"cruse\"›)] a: Modulates<f64>",
        "there is no child `cruse` here (cruise)",
    );
}

#[test]
fn names_are_different_where_they_would_be_confused() {
    check_field(
        "motor",
        "#[import] a: Import<f64>, #[import(name = \"a\")] ‹b›: Import<f64>",
        "two are called `a`",
    );
    check_field(
        "motor",
        "#[export] a: Export<f64>, #[modulation(default = 0.0, name = \"a\")] ‹b›: Modulation<f64>",
        "two are called `a`",
    );
    check_field(
        "motor",
        "#[modulation(default = 0.0)] ‹children›: Modulation<f64>",
        "a meaning of its own",
    );
    check_field(
        "motor",
        "#[export] ‹period›: Export<f64>",
        "a variable `period` of its own",
    );
    check_field(
        "driver",
        "#[command(neutral = 0.0, validity = \"1s\")] ‹period›: Command<f64>",
        "a variable `period` of its own",
    );
    assert!(schema("#[schema(motor, period = \"1s\")] struct Stop { #[import] a: Import<f64>, #[export(name = \"a\")] b: Export<f64> }").is_ok());
}

#[test]
fn a_value_is_a_plain_c_structure_with_named_fields() {
    check(value, "struct ‹Scan› { a: u8 }", "add `#[repr(C)]`");
    check(
        value,
        "#[repr(C, ‹packed›)] struct Scan { a: u8 }",
        "`#[repr(C)]` and nothing else",
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
