//! Writes `jde_run.h` from the source of the crate `jde-c`: its tables, and its functions in the order of the modules.

use std::fmt::Write;

use syn::{FnArg, Item, ItemFn, ItemStruct, Pat, ReturnType};

use super::abi::{Writer, declare, parse};
use super::names::{block, structure};

/// The tables, and the functions in the order of the declarations in C.
const SOURCES: [&str; 6] = [
    include_str!("../../../programs/c/src/tables.rs"),
    include_str!("../../../programs/c/src/boundary.rs"),
    include_str!("../../../programs/c/src/application.rs"),
    include_str!("../../../programs/c/src/run.rs"),
    include_str!("../../../programs/c/src/values.rs"),
    include_str!("../../../programs/c/src/operations.rs"),
];

pub(super) fn header() -> String {
    let files = SOURCES.map(parse);
    let [tables, modules @ ..] = &files;
    let items: Vec<&Item> = tables.items.iter().collect();
    let writer = Writer::new(&items, &SOURCES);
    let mut out = writer.head(tables, "programs/c/src");
    out.push_str("#ifndef JDE_RUN_H\n#define JDE_RUN_H\n\n#include \"jde.h\"\n\n");
    out.push_str("#ifdef __cplusplus\nextern \"C\" {\n#endif\n");
    for item in &items {
        if let Item::Const(item) = item {
            writer.constant(item, &mut out);
        }
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
        let name = structure(&item.ident.to_string());
        let _ = writeln!(out, "typedef struct {name} {name};");
    }
    for item in &structures {
        writer.structure(item, &mut out);
    }
    for item in modules.iter().flat_map(|file| &file.items) {
        if let Item::Fn(item) = item
            && item.sig.abi.is_some()
        {
            function(&writer, item, &mut out);
        }
    }
    out.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    out
}

fn function(writer: &Writer, item: &ItemFn, out: &mut String) {
    let arguments: Vec<String> = item.sig.inputs.iter().map(argument).collect();
    let arguments = match arguments.as_slice() {
        [] => "void".to_owned(),
        arguments => arguments.join(", "),
    };
    let declared = format!("{}({arguments})", item.sig.ident);
    let declared = match &item.sig.output {
        ReturnType::Default => format!("void {declared}"),
        ReturnType::Type(_, ty) => declare(ty, &declared),
    };
    out.push('\n');
    out.push_str(&block(&writer.doc(&item.attrs), ""));
    let _ = writeln!(out, "{declared};");
}

fn argument(argument: &FnArg) -> String {
    let FnArg::Typed(argument) = argument else {
        unreachable!("a function of C has no `self`")
    };
    let Pat::Ident(name) = &*argument.pat else {
        unreachable!("an argument has a name")
    };
    declare(&argument.ty, &name.ident.to_string())
}
