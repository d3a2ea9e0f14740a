//! Looks into a library's file before the loader of the system maps it: a truncated or foreign file would otherwise end the
//! process with a signal, and a wrong library would run its constructors. Reads only; loads nothing.

use std::fs::File;

use object::Endianness;
use object::elf::{ET_DYN, FileHeader64, PT_LOAD, SHT_DYNSYM, SHT_NOBITS};
use object::read::elf::{FileHeader, ProgramHeader, SectionHeader, Sym};
use object::read::{ReadCache, ReadRef};

/// What is looked at of a file: a few of its parts, whatever its size.
pub(super) type Parts = ReadCache<File>;

/// Checks that a file is a whole shared library for this machine.
pub(super) fn check(parts: &Parts) -> Result<(), String> {
    let bad = |error: object::Error| format!("it is not a shared library that can be loaded ({error})");
    let length = parts
        .len()
        .map_err(|()| String::from("its length cannot be told"))?;
    if length == 0 {
        return Err(String::from("the file is empty; build or copy it again"));
    }
    if parts.read_bytes_at(0, 4) != Ok(b"\x7fELF") {
        return Err(String::from(
            "it is not a shared library (no ELF header); build it as a cdylib (or with cc -shared)",
        ));
    }
    let header = FileHeader64::<Endianness>::parse(parts).map_err(bad)?;
    let endian = header.endian().map_err(bad)?;
    if header.e_type(endian) != ET_DYN {
        return Err(String::from(
            "it is an ELF file, but no shared library; build it as a cdylib (or with cc -shared)",
        ));
    }
    let machine = header.e_machine(endian);
    if machine != own_machine() {
        return Err(format!(
            "it was built for another processor (ELF machine {machine:?}, this one is {:?})",
            own_machine()
        ));
    }
    let whole = |offset: u64, size: u64| offset.checked_add(size).is_some_and(|end| end <= length);
    let segments = header
        .program_headers(endian, parts)
        .map_err(|_| truncated(length))?;
    for segment in segments {
        if segment.p_type(endian) == PT_LOAD && !whole(segment.p_offset(endian), segment.p_filesz(endian)) {
            return Err(truncated(length));
        }
    }
    let sections = header.sections(endian, parts).map_err(|_| truncated(length))?;
    for section in sections.iter() {
        let held = section.sh_type(endian) != SHT_NOBITS;
        if held && !whole(section.sh_offset(endian), section.sh_size(endian)) {
            return Err(truncated(length));
        }
    }
    Ok(())
}

/// Bytes of an exported symbol as the file states them; `None` if there is no such symbol.
pub(super) fn symbol_size(parts: &Parts, symbol: &str) -> Option<u64> {
    let header = FileHeader64::<Endianness>::parse(parts).ok()?;
    let endian = header.endian().ok()?;
    let sections = header.sections(endian, parts).ok()?;
    let symbols = sections.symbols(endian, parts, SHT_DYNSYM).ok()?;
    symbols
        .iter()
        .find(|entry| {
            !entry.is_undefined(endian) && entry.name(endian, symbols.strings()) == Ok(symbol.as_bytes())
        })
        .map(|entry| entry.st_size(endian))
}

/// Whether a file claims to be a plugin, for listings: no more than a look.
pub(super) fn is_plugin(parts: &Parts, symbol: &str) -> bool {
    check(parts).is_ok() && symbol_size(parts, symbol).is_some()
}

fn truncated(length: u64) -> String {
    format!(
        "the file ends before the library does (it has {length} bytes): it is truncated or still being written; build \
         or copy it again"
    )
}

fn own_machine() -> object::elf::Machine {
    if cfg!(target_arch = "aarch64") {
        object::elf::EM_AARCH64
    } else if cfg!(target_arch = "riscv64") {
        object::elf::EM_RISCV
    } else {
        object::elf::EM_X86_64
    }
}
