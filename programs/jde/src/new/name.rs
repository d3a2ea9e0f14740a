//! Names that are valid for a folder, a package, a schema and a Rust type.

/// The longest name, in bytes. It is part of every line of the oscilloscope.
const MAX_LENGTH: usize = 32;
/// Names that no Rust package may have, and those of existing plugins.
const RESERVED: &str = "abstract alloc as async await become box break build carmen const continue core crate deps do dyn else \
    enum example examples extern false family final fn for gen goon if impl in incremental jde-schema jde-types let loop \
    macro match mod move mut override pair priv proc-macro pub ref return self sim static std stop struct super test trait \
    true try type typeof unsafe unsized use vff virtual where while yield";
/// The keywords and standard modules of Python, and packages that schemas and their tests import: a file of such a
/// name cannot be imported, or hides the module.
const RESERVED_IN_PYTHON: &str = "abc aifc and annotationlib antigravity argparse array assert ast asynchat asyncio asyncore atexit audioop \
    base64 bdb binascii bisect builtins bz2 calendar cgi cgitb chunk class cmath cmd code codecs codeop \
    collections colorsys compileall compression concurrent configparser contextlib contextvars copy copyreg crypt \
    csv ctypes curses dataclasses datetime dbm decimal def del difflib dis distutils doctest elif email encodings \
    ensurepip errno except faulthandler fcntl filecmp fileinput finally fnmatch fractions from ftplib functools gc \
    genericpath getopt getpass gettext glob global graphlib grp gzip hashlib heapq hmac html http idlelib imaplib \
    imghdr imp import importlib inspect io ipaddress is itertools json keyword lambda lib2to3 linecache locale \
    logging lzma mailbox mailcap marshal math mimetypes mmap modulefinder msilib msvcrt multiprocessing netrc nis \
    nntplib nonlocal not nt ntpath nturl2path numbers numpy opcode operator optparse or os ossaudiodev pass \
    pathlib pdb pickle pickletools pipes pkgutil platform plistlib poplib posix posixpath pprint profile pstats \
    pty pwd py-compile pyclbr pydoc pydoc-data pyexpat pytest queue quopri raise random re readline reprlib \
    resource rlcompleter runpy sched secrets select selectors shelve shlex shutil signal site smtpd smtplib sndhdr \
    socket socketserver spwd sqlite3 sre-compile sre-constants sre-parse ssl stat statistics string stringprep \
    subprocess sunau symtable sys sysconfig syslog tabnanny tarfile telnetlib tempfile termios textwrap this \
    threading time timeit tkinter token tokenize tomllib trace traceback tracemalloc tty turtle turtledemo types \
    typing typing-extensions unicodedata unittest urllib uu uuid venv warnings wave weakref webbrowser winreg \
    winsound with wsgiref xdrlib xml xmlrpc zipapp zipfile zipimport zlib zoneinfo";
/// A module that each template in Python imports, and no other one.
const PYTHON_PACKAGE: &str = "jde";

/// A name in both forms.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Name {
    /// "follow-wall".
    pub(super) kebab: String,
    /// "FollowWall".
    pub(super) camel: String,
}

impl Name {
    /// Checks a name. `is_taken` returns whether the template uses a word for something else.
    ///
    /// # Errors
    /// The reason why the name is invalid.
    pub(super) fn new(text: &str, is_taken: impl Fn(&str) -> bool) -> Result<Self, String> {
        let parts: Vec<&str> = text.split('-').collect();
        let is_valid = |part: &&str| {
            !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        let starts_with_letter = text.starts_with(|c: char| c.is_ascii_lowercase());
        if !starts_with_letter || !parts.iter().all(is_valid) {
            return Err(format!("`{}` cannot be a name", text.escape_debug()));
        }
        if text.len() > MAX_LENGTH {
            return Err(format!(
                "`{text}` is too long for a name; {MAX_LENGTH} letters is the most"
            ));
        }
        let camel: String = parts
            .iter()
            .map(|part| part[..1].to_ascii_uppercase() + &part[1..])
            .collect();
        let is_among = |words: &str| words.split(' ').any(|word| word == text);
        if is_among(RESERVED) || is_taken(text) || is_taken(&camel) {
            return Err(format!("the name `{text}` is taken"));
        }
        if is_taken(PYTHON_PACKAGE) && is_among(RESERVED_IN_PYTHON) {
            return Err(format!(
                "the name `{text}` is taken: Python has a keyword or a module of that name"
            ));
        }
        Ok(Self {
            kebab: text.to_owned(),
            camel,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Name;

    #[test]
    fn a_name_is_written_with_hyphens_and_as_a_type() {
        let name = Name::new("follow-wall-2", |_| false).unwrap();
        assert_eq!(
            (name.kebab.as_str(), name.camel.as_str()),
            ("follow-wall-2", "FollowWall2")
        );
    }

    #[test]
    fn invalid_names_of_packages_and_types_are_refused() {
        for text in [
            "",
            "-",
            "a--b",
            "-a",
            "a-",
            "2a",
            "Follow",
            "follow_wall",
            "../up",
            "a b",
            "ä",
            "fn",
            "stop",
        ] {
            assert!(Name::new(text, |_| false).is_err(), "{text}");
        }
        assert!(Name::new(&"a".repeat(33), |_| false).is_err());
    }

    #[test]
    fn words_of_python_are_refused_for_templates_in_python_alone() {
        for text in [
            "class",
            "lambda",
            "random",
            "pytest",
            "concurrent",
            "typing-extensions",
        ] {
            let wrong = Name::new(text, |word| word == "jde").unwrap_err();
            assert!(
                wrong.ends_with("Python has a keyword or a module of that name"),
                "{wrong}"
            );
            assert!(Name::new(text, |_| false).is_ok(), "{text}");
        }
        assert!(Name::new("randomly", |word| word == "jde").is_ok());
    }

    #[test]
    fn a_name_that_the_template_needs_is_refused() {
        assert!(Name::new("twist", |word| word == "Twist").is_err());
    }
}
