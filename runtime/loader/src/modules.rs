//! The modules beside a file of Python that it imports, as far as its text tells: what another build of it may consist of.
//! It runs nothing, and follows no import out of the folder or package of the file.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// The most modules that are followed. A file with more has a package for itself.
const MAX_MODULES: usize = 64;
/// The largest module that is read, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Returns the modules that a file imports from beside it, and those that they import, in the order in which they are found.
/// A text that only looks like an import may add one.
#[must_use]
pub fn of(file: &Path) -> Vec<PathBuf> {
    let root = Root::of(file);
    let mut found: Vec<PathBuf> = Vec::new();
    let mut unread = VecDeque::from([file.to_owned()]);
    while let Some(next) = unread.pop_front() {
        let Ok(text) = jde_files::read_text(&next, MAX_BYTES) else {
            continue;
        };
        for module in text.lines().flat_map(|line| root.imported(&next, line)) {
            if found.len() < MAX_MODULES && module != file && !found.contains(&module) {
                found.push(module.clone());
                unread.push_back(module);
            }
        }
    }
    found
}

/// Where the modules of a file are searched for.
struct Root {
    /// The folder of the file, or the one that holds its package.
    folder: PathBuf,
    /// The outermost package of the file. Modules of others beside it are installed, and no part of it.
    package: Option<String>,
}

impl Root {
    fn of(file: &Path) -> Self {
        let mut folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let mut package = None;
        while folder.join("__init__.py").is_file()
            && let (Some(name), Some(parent)) = (folder.file_name(), folder.parent())
        {
            package = Some(name.to_string_lossy().into_owned());
            folder = parent.to_owned();
        }
        Self { folder, package }
    }

    /// Returns the modules that a line of a file imports.
    fn imported(&self, file: &Path, line: &str) -> Vec<PathBuf> {
        let line = line.trim_start();
        let line = line.split('#').next().unwrap_or_default();
        let names = |list: &str| {
            let list = list.trim().trim_start_matches('(').trim_end_matches(')');
            let names = list.split(',').filter_map(|name| name.split_whitespace().next());
            names.map(str::to_owned).collect::<Vec<_>>()
        };
        let mut files = Vec::new();
        if let Some(list) = line.strip_prefix("import ") {
            for name in names(list) {
                files.extend(self.files(file, &name, &[]));
            }
        } else if let Some((module, list)) = line
            .strip_prefix("from ")
            .and_then(|rest| rest.split_once(" import"))
        {
            files.extend(self.files(file, module.trim(), &names(list)));
        }
        files
    }

    /// Returns the files of a module, of the packages that it is in, and of those of `names` that are modules in it.
    fn files(&self, file: &Path, module: &str, names: &[String]) -> Vec<PathBuf> {
        let name = module.trim_start_matches('.');
        let parts: Vec<_> = name.split('.').filter(|part| !part.is_empty()).collect();
        let beside = file.parent().unwrap_or(Path::new(""));
        let bases = match module.len() - name.len() {
            0 if self
                .package
                .as_deref()
                .is_some_and(|package| Some(&package) != parts.first()) =>
            {
                vec![beside]
            }
            0 => vec![self.folder.as_path(), beside],
            dots => beside.ancestors().skip(dots - 1).take(1).collect(),
        };
        let mut files = Vec::new();
        for base in bases.into_iter().filter(|base| base.starts_with(&self.folder)) {
            let mut path = base.to_owned();
            for part in &parts {
                path.push(part);
                files.extend(file_of(&path));
            }
            files.extend(names.iter().filter_map(|name| file_of(&path.join(name))));
        }
        files
    }
}

/// Returns the file of the module at a path without its extension.
fn file_of(path: &Path) -> Option<PathBuf> {
    let module = path.with_added_extension("py");
    [module, path.join("__init__.py")]
        .into_iter()
        .find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Writes files, and returns the names of the modules of the first.
    fn modules(files: &[(&str, &str)]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        }
        let found = of(&folder.path().join(files[0].0));
        let name = |file: PathBuf| file.strip_prefix(folder.path()).unwrap().display().to_string();
        found.into_iter().map(name).collect()
    }

    #[test]
    fn modules_beside_the_file_are_found_and_those_that_they_import() {
        let text = "import math, helper as h  # import other\nfrom tools.near import (\n    one,\n)\nfrom tools import far\n";
        let found = modules(&[
            ("hog.py", text),
            ("helper.py", "def f():\n    from deep import x\n"),
            ("deep.py", "import hog\n"),
            ("other.py", ""),
            ("tools/near.py", ""),
            ("tools/far.py", ""),
        ]);
        assert_eq!(found, ["helper.py", "tools/near.py", "tools/far.py", "deep.py"]);
    }

    #[test]
    fn a_package_has_its_own_modules_and_none_that_are_installed_beside_it() {
        let found = modules(&[
            (
                "motion/slow.py",
                "from . import near\nfrom .deep import far\nimport motion.all\nimport numpy\nfrom .. import x\n",
            ),
            ("motion/__init__.py", ""),
            ("motion/near.py", ""),
            ("motion/deep/__init__.py", ""),
            ("motion/deep/far.py", ""),
            ("motion/all.py", ""),
            ("numpy/__init__.py", ""),
        ]);
        assert_eq!(
            found,
            [
                "motion/near.py",
                "motion/deep/__init__.py",
                "motion/deep/far.py",
                "motion/__init__.py",
                "motion/all.py"
            ]
        );
    }
}
