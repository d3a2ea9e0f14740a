//! Writes `jde.h` from the source of `jde_abi::raw`. An item of an unknown form is an error; no item is
//! omitted silently.

use std::collections::BTreeSet;
use std::fmt::Write;

use jde_core::POLICIES;
use quote::ToTokens;
use syn::{
    Attribute, Expr, ExprLit, Field, File, GenericArgument, Item, ItemConst, ItemStruct, Lit, Meta, NamedArg,
};
use syn::{PathArguments, PointerMutability, ReturnType, Type};

use super::names::{block, comment, constant, member, structure};

/// The sources of the ABI, in the order of the declarations in C.
const SOURCES: [&str; 8] = [
    include_str!("../../../plugin/abi/src/raw/mod.rs"),
    include_str!("../../../plugin/abi/src/raw/host.rs"),
    include_str!("../../../plugin/abi/src/raw/panel.rs"),
    include_str!("../../../plugin/abi/src/raw/state.rs"),
    include_str!("../../../plugin/abi/src/raw/inspect.rs"),
    include_str!("../../../plugin/abi/src/raw/guard.rs"),
    include_str!("../../../plugin/abi/src/raw/lists.rs"),
    include_str!("../../../plugin/abi/src/raw/turns.rs"),
];
/// The part of `jde.h` that exists only in C: macros and functions that use the tables.
const HELPERS: &str = include_str!("helpers.h");

pub(super) fn header() -> String {
    let files = SOURCES.map(parse);
    let items: Vec<&Item> = files.iter().flat_map(|file| &file.items).collect();
    let writer = Writer::new(&items, &SOURCES);
    let mut out = writer.head(&files[0], "plugin/abi/src/raw/mod.rs");
    out.push_str("#ifndef JDE_H\n#define JDE_H\n\n");
    out.push_str("#include <math.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n\n");
    out.push_str("#ifdef __cplusplus\nextern \"C\" {\n#endif\n");
    for item in &items {
        if let Item::Const(item) = item {
            writer.constant(item, &mut out);
        }
    }
    out.push('\n');
    for kind in POLICIES {
        out.push_str(&block(&format!("Policy: {}.", kind.summary), ""));
        let name = constant(&format!("POLICY_{}", kind.name.replace('-', "_").to_uppercase()));
        let _ = writeln!(out, "#define {name} {}u", kind.code);
    }
    out.push('\n');
    let structures: Vec<&ItemStruct> = items
        .iter()
        .filter_map(|item| match item {
            Item::Struct(item) => Some(item),
            _ => None,
        })
        .collect();
    for item in &structures {
        // A plugin exports a variable with the name of this type. C permits that only if the name is a tag
        // and not a typedef.
        if item.ident != "Plugin" {
            let name = structure(&item.ident.to_string());
            let _ = writeln!(out, "typedef struct {name} {name};");
        }
    }
    for item in &structures {
        writer.structure(item, &mut out);
    }
    out.push('\n');
    out.push_str(HELPERS);
    out.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    out
}

/// Parses a source of declarations.
pub(super) fn parse(source: &str) -> File {
    match syn::parse_file(source) {
        Ok(file) => file,
        Err(error) => unreachable!("it compiles, so it parses: {error}"),
    }
}

/// Writes declarations in C.
pub(super) struct Writer {
    constants: BTreeSet<String>,
    sources: &'static [&'static str],
}

impl Writer {
    pub(super) fn new(items: &[&Item], sources: &'static [&'static str]) -> Self {
        let constants = items.iter().filter_map(|item| match item {
            Item::Const(item) => Some(item.ident.to_string()),
            _ => None,
        });
        Self {
            constants: constants.collect(),
            sources,
        }
    }

    /// Returns the comment at the head of a header, which is that of a source.
    pub(super) fn head(&self, file: &File, path: &str) -> String {
        let mut out = String::from("/*\n");
        for line in self.doc(&file.attrs).lines() {
            let _ = writeln!(out, "{}", format!(" * {line}").trim_end());
        }
        let _ = writeln!(
            out,
            " *\n * Generated from {path}; `cargo xtask headers` renews it.\n */"
        );
        out
    }

    pub(super) fn constant(&self, item: &ItemConst, out: &mut String) {
        let name = item.ident.to_string();
        let doc = self.doc(&item.attrs);
        let value = match (&*name, &*item.expr) {
            // The only constant that is computed rather than a literal.
            ("MAGIC", _) => format!("UINT64_C({:#x})", jde_abi::raw::MAGIC),
            (
                _,
                Expr::Lit(ExprLit {
                    lit: Lit::Str(text), ..
                }),
            ) => format!("{:?}", text.value()),
            (
                _,
                Expr::Lit(ExprLit {
                    lit: Lit::Int(number),
                    ..
                }),
            ) => {
                let unsigned = item.ty.to_token_stream().to_string().starts_with('u');
                format!("{}{}", number.base10_digits(), if unsigned { "u" } else { "" })
            }
            (_, value) => unreachable!(
                "a constant of the ABI is a literal, not {}",
                value.to_token_stream()
            ),
        };
        if self.begins_a_group(&name) {
            out.push('\n');
        }
        out.push_str(&block(&doc, ""));
        let _ = writeln!(out, "#define {} {value}", constant(&name));
    }

    pub(super) fn structure(&self, item: &ItemStruct, out: &mut String) {
        let name = structure(&item.ident.to_string());
        let members: Vec<&Field> = item.fields.iter().filter(|field| is_public(field)).collect();
        out.push('\n');
        out.push_str(&block(&self.doc(&item.attrs), ""));
        if members.is_empty() {
            // C uses it only through pointers.
            let _ = writeln!(out, "struct {name};");
            return;
        }
        let _ = writeln!(out, "struct {name} {{");
        for field in members {
            out.push_str(&block(&self.doc(&field.attrs), "    "));
            let name = field
                .ident
                .as_ref()
                .map(|name| member(&name.to_string()))
                .unwrap_or_default();
            let _ = writeln!(out, "    {};", declare(&field.ty, &name));
        }
        out.push_str("};\n");
    }

    pub(super) fn doc(&self, attributes: &[Attribute]) -> String {
        let mut lines = Vec::new();
        for attribute in attributes {
            if let Meta::NameValue(pair) = &attribute.meta
                && pair.path.is_ident("doc")
                && let Expr::Lit(ExprLit {
                    lit: Lit::Str(text), ..
                }) = &pair.value
            {
                let text = text.value();
                lines.push(text.strip_prefix(' ').unwrap_or(&text).to_owned());
            }
        }
        comment(&lines.join("\n"), &self.constants)
    }

    /// Returns whether the source has an empty line above a constant and its comment.
    fn begins_a_group(&self, name: &str) -> bool {
        let declaration = format!("pub const {name}: ");
        let above = self
            .sources
            .iter()
            .find_map(|source| source.split_once(&declaration))
            .map_or("", |(above, _)| above);
        let mut lines = above.lines().rev().skip_while(|line| line.starts_with("///"));
        lines.next().is_some_and(str::is_empty)
    }
}

fn is_public(field: &Field) -> bool {
    matches!(field.vis, syn::Visibility::Public(_))
}

/// Returns the declaration of `name` with the type `ty`.
pub(super) fn declare(ty: &Type, name: &str) -> String {
    let spaced = |ty: String| {
        if ty.ends_with('*') {
            format!("{ty}{name}")
        } else {
            format!("{ty} {name}")
        }
    };
    match ty {
        Type::FnPtr(function) => {
            let arguments: Vec<String> = function.inputs.iter().map(argument).collect();
            let result = match &function.output {
                ReturnType::Default => "void ".to_owned(),
                ReturnType::Type(_, ty) => declare(ty, ""),
            };
            format!("{result}(*{name})({})", arguments.join(", "))
        }
        Type::Ptr(pointer) => {
            let target = declare(&pointer.elem, "");
            let target = target.trim_end();
            match pointer.mutability {
                PointerMutability::Const(_) if target.ends_with('*') => spaced(format!("{target}const *")),
                PointerMutability::Const(_) => spaced(format!("const {target} *")),
                PointerMutability::Mut(_) if target.ends_with('*') => spaced(format!("{target}*")),
                PointerMutability::Mut(_) => spaced(format!("{target} *")),
            }
        }
        Type::Array(array) => {
            let length = array.len.to_token_stream();
            format!("{}[{length}]", declare(&array.elem, name))
        }
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else {
                unreachable!("a path has segments")
            };
            if let PathArguments::AngleBracketed(arguments) = &last.arguments
                && let Some(GenericArgument::Type(inner)) = arguments.args.first()
            {
                // An optional function is a pointer that may be null.
                return declare(inner, name);
            }
            spaced(scalar(&last.ident.to_string()))
        }
        other => unreachable!("the ABI has no type {}", other.to_token_stream()),
    }
}

fn argument(argument: &NamedArg) -> String {
    let name = argument
        .name
        .as_ref()
        .map(|(name, _)| name.to_string())
        .filter(|name| name != "_");
    declare(&argument.ty, &name.unwrap_or_default())
        .trim_end()
        .to_owned()
}

fn scalar(name: &str) -> String {
    match name {
        "u8" => "uint8_t".into(),
        "u32" => "uint32_t".into(),
        "u64" => "uint64_t".into(),
        "i32" => "int32_t".into(),
        "f64" => "double".into(),
        "c_char" => "char".into(),
        "c_void" => "void".into(),
        other => structure(other),
    }
}
