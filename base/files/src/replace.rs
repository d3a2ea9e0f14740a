//! Replaces a file as a whole: whoever reads it, and whatever ends the machine meanwhile, finds the old content or the
//! new one.

use std::fs::{self, File, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
use std::path::{Path, PathBuf};

/// Readable and writable as the user's mask permits, like any new file.
const NEW_FILE: u32 = 0o666;

/// Replaces the file by what `write` writes, or creates it. The content is written beside it and is on the disk before it
/// takes the place of the old one. The file keeps its permissions, and its owner if this user may give files away; a
/// symbolic link stays one. What is no regular file, such as a pipe or a terminal, is written in place. Waits for the disk.
///
/// # Errors
/// What `write` returns, or the new file cannot be created, synced or renamed. The old content is there then, and nothing
/// else is left.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(old) => Some(old),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        return write(&mut File::options().write(true).open(path)?);
    }
    let path = match &old {
        Some(_) => fs::canonicalize(path)?,
        None => path.to_owned(),
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut file = tempfile::Builder::new()
        .prefix(".jde-")
        .permissions(Permissions::from_mode(NEW_FILE))
        .tempfile_in(&folder)?;
    if let Some(old) = old {
        // An administrator's tool must not take the file from its user; another user may not give files away, and owns the
        // new one. Before the permissions, because a change of the owner may clear some.
        let _ = fchown(file.as_file(), Some(old.uid()), Some(old.gid()));
        file.as_file().set_permissions(old.permissions())?;
    }
    write(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(&path)?;
    // The name is on the disk when the folder is.
    File::open(&folder)?.sync_all()
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::os::unix::fs::{chown, symlink};

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = (fs::read_dir(folder).unwrap())
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_old_content_stays_until_the_new_one_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        fs::write(&path, "old").unwrap();
        let failed = replace(&path, |file| {
            file.write_all(b"half")?;
            assert_eq!(fs::read(&path)?, b"old");
            Err(ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["page.html"]);
        replace(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["page.html"]);
    }

    #[test]
    fn permissions_and_links_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("file"), folder.path().join("link"));
        replace(&path, |file| file.write_all(b"1")).unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink("file", &link).unwrap();
        replace(&link, |file| file.write_all(b"2")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"2");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn an_administrator_leaves_a_file_to_its_owner() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "1").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        // Only an administrator may give a file away; any other user keeps it.
        let _ = chown(&path, Some(1), Some(1));
        let old = fs::metadata(&path).unwrap();
        replace(&path, |file| file.write_all(b"2")).unwrap();
        let new = fs::metadata(&path).unwrap();
        assert_eq!((new.uid(), new.gid()), (old.uid(), old.gid()));
        assert_eq!(new.mode() & 0o777, 0o640);
    }

    #[test]
    fn what_is_no_regular_file_is_written_in_place() {
        replace(Path::new("/dev/null"), |file| file.write_all(b"1")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
