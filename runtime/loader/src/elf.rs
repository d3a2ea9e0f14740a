//! Checks a library's file before the system's loader maps it. A truncated or foreign file would otherwise
//! end the process with a signal, and a wrong library would run its constructors. It loads nothing.

use std::fs::File;

use object::Endianness;
use object::elf::{ET_DYN, FileHeader64, PT_LOAD, SHT_DYNSYM, SHT_NOBITS};
use object::read::elf::{FileHeader, ProgramHeader, SectionHeader, Sym};
use object::read::{ReadCache, ReadRef};

/// A file of which only the needed parts are read.
pub(super) type ElfFile = ReadCache<File>;

/// The most segments, and the most sections. A library has some dozens.
const MAX_PARTS: u32 = 1 << 16;
/// The largest table of exported symbols, bytes. It is read as a whole.
const MAX_SYMBOLS: u64 = 64 << 20;
/// The number of bytes of a symbol that are read: the magic number of a plugin and its version.
const SYMBOL_HEAD_BYTES: usize = 16;

/// Checks that a file is a complete shared library for this machine.
pub(super) fn check(parts: &ElfFile) -> Result<(), String> {
    let unloadable =
        |error: object::Error| format!("it is not a shared library that can be loaded ({error})");
    let length = parts
        .len()
        .map_err(|()| String::from("its length cannot be determined"))?;
    if length == 0 {
        return Err(String::from("the file is empty; build or copy it again"));
    }
    if parts.read_bytes_at(0, 4) != Ok(b"\x7fELF") {
        return Err(String::from(
            "it is not a shared library (no ELF header); build it as a cdylib (or with cc -shared)",
        ));
    }
    let header = FileHeader64::<Endianness>::parse(parts).map_err(unloadable)?;
    let endian = header.endian().map_err(unloadable)?;
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
    let (segments, sections) = (header.phnum(endian, parts), header.shnum(endian, parts));
    if segments.is_ok_and(|count| count > MAX_PARTS) || sections.is_ok_and(|count| count > MAX_PARTS) {
        return Err(format!("it has more than {MAX_PARTS} sections or segments"));
    }
    let is_within = |offset: u64, size: u64| offset.checked_add(size).is_some_and(|end| end <= length);
    let segments = header
        .program_headers(endian, parts)
        .map_err(|_| truncated(length))?;
    for segment in segments {
        if segment.p_type(endian) == PT_LOAD && !is_within(segment.p_offset(endian), segment.p_filesz(endian))
        {
            return Err(truncated(length));
        }
    }
    let sections = header.sections(endian, parts).map_err(|_| truncated(length))?;
    for section in sections.iter() {
        let has_content = section.sh_type(endian) != SHT_NOBITS;
        if has_content && !is_within(section.sh_offset(endian), section.sh_size(endian)) {
            return Err(truncated(length));
        }
        if section.sh_type(endian) == SHT_DYNSYM && section.sh_size(endian) > MAX_SYMBOLS {
            return Err(format!(
                "its exported symbols need more than {} MiB",
                MAX_SYMBOLS >> 20
            ));
        }
    }
    Ok(())
}

/// An exported symbol, as the file describes it.
pub(super) struct Symbol {
    /// Its size in bytes according to the file.
    pub(super) size: u64,
    /// Its first bytes, before any relocation or code runs; `None` if the file does not contain them.
    pub(super) head: Option<[u8; SYMBOL_HEAD_BYTES]>,
}

/// Returns the exported symbol of that name, if there is one.
pub(super) fn symbol(parts: &ElfFile, name: &str) -> Option<Symbol> {
    let header = FileHeader64::<Endianness>::parse(parts).ok()?;
    let endian = header.endian().ok()?;
    let sections = header.sections(endian, parts).ok()?;
    let symbols = sections.symbols(endian, parts, SHT_DYNSYM).ok()?;
    let entry = symbols.iter().find(|entry| {
        !entry.is_undefined(endian) && entry.name(endian, symbols.strings()) == Ok(name.as_bytes())
    })?;
    let address = entry.st_value(endian);
    let segments = header.program_headers(endian, parts).ok()?;
    let offset = segments.iter().find_map(|segment| {
        let within = address.checked_sub(segment.p_vaddr(endian))?;
        let is_contained = within.checked_add(SYMBOL_HEAD_BYTES as u64)? <= segment.p_filesz(endian);
        let is_match = segment.p_type(endian) == PT_LOAD && is_contained;
        is_match.then(|| segment.p_offset(endian).checked_add(within))?
    });
    let head = offset.and_then(|offset| parts.read_bytes_at(offset, SYMBOL_HEAD_BYTES as u64).ok());
    Some(Symbol {
        size: entry.st_size(endian),
        head: head.and_then(|head| head.try_into().ok()),
    })
}

/// Whether a library uses the C++ runtime, judged by its undefined symbols.
pub(super) fn is_cpp(parts: &ElfFile) -> bool {
    let uses_cpp = || {
        let header = FileHeader64::<Endianness>::parse(parts).ok()?;
        let endian = header.endian().ok()?;
        let sections = header.sections(endian, parts).ok()?;
        let symbols = sections.symbols(endian, parts, SHT_DYNSYM).ok()?;
        let of_cpp = |name: &[u8]| {
            name == b"__gxx_personality_v0" || name == b"__cxa_throw" || name.starts_with(b"_ZSt")
        };
        Some(symbols.iter().any(|entry| {
            entry.is_undefined(endian) && entry.name(endian, symbols.strings()).is_ok_and(of_cpp)
        }))
    };
    uses_cpp().unwrap_or(false)
}

/// Whether a file appears to be a plugin. A superficial check, for listings.
pub(super) fn is_plugin(parts: &ElfFile, name: &str, mark: &[u8]) -> bool {
    let has_mark = |symbol: Symbol| symbol.head.is_some_and(|head| head.starts_with(mark));
    check(parts).is_ok() && symbol(parts, name).is_some_and(has_mark)
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
