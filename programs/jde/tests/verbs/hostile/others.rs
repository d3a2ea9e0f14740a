//! Definitions of messages, keys of the link, the folder in which applications announce themselves, and settings.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;

use super::files::{app, lines, pipe, sparse, write};

/// The schemas of an application without a robot.
const PAIR: &str = "[schemas.talker]\ntype = \"pair/talker\"\n[schemas.listener]\ntype = \"pair/listener\"\n\
    imports = { count = \"talker.count\" }\n";

/// An application with a topic of a type that the file `acme_msgs/msg/A.msg` defines.
pub(super) fn defined(folder: &Path, text: &str) {
    let folders = folder.join("acme_msgs/msg");
    fs::create_dir_all(&folders).expect("a folder");
    if !text.is_empty() {
        write(&folders, "A.msg", text);
    }
    app(
        folder,
        "roots = [\"a\"]\ninterfaces = [\".\"]\n[schemas.a]\ntype = \"ros2/topics\"\n\
         subscribe.\"/a\" = { as = \"a\", type = \"acme_msgs/msg/A\" }\n",
    );
}

/// Definitions of which each has a thousand of the next.
pub(super) fn multiplied(folder: &Path) {
    defined(folder, "A0[1000] a\n");
    for number in 0..14 {
        let text = format!("A{}[1000] a\nA{}[1000] b\n", number + 1, number + 1);
        write(&folder.join("acme_msgs/msg"), &format!("A{number}.msg"), text);
    }
    write(&folder.join("acme_msgs/msg"), "A14.msg", "float64 a\n");
}

/// Ten thousand definitions, each of which names the next.
pub(super) fn chained(folder: &Path) {
    defined(folder, "A0 a\n");
    for number in 0..5000 {
        write(
            &folder.join("acme_msgs/msg"),
            &format!("A{number}.msg"),
            format!("A{} a\n", number + 1),
        );
    }
    write(&folder.join("acme_msgs/msg"), "A5000.msg", "float64 a\n");
}

/// A definition that is a pipe.
pub(super) fn piped(folder: &Path) {
    defined(folder, "");
    pipe(&folder.join("acme_msgs/msg"), "A.msg");
}

/// The folder of running applications, with entries that are none.
pub(super) fn announced(folder: &Path) {
    let folder = &runtime(folder);
    write(folder, "0123456789abcdef.json", "[".repeat(1 << 20));
    sparse(folder, "1123456789abcdef.json");
    pipe(folder, "2123456789abcdef.json");
    symlink("/dev/zero", folder.join("3123456789abcdef.json")).expect("a link");
    symlink("/dev/zero", folder.join("3123456789abcdef.sock")).expect("a link");
    fs::create_dir(folder.join("4123456789abcdef.json")).expect("a folder");
    (0..3000).for_each(|n| write(folder, &format!("{n:016x}.json"), "{}"));
    (3000..6000).for_each(|n| symlink("/dev/zero", folder.join(format!("{n:016x}.json"))).expect("a link"));
}

/// The folder of running applications, whose lock is a pipe.
pub(super) fn locked(folder: &Path) {
    pipe(&runtime(folder), "lock");
    app(folder, &format!("roots = [\"listener\"]\n{PAIR}"));
}

fn runtime(folder: &Path) -> std::path::PathBuf {
    let folder = folder.join("jde");
    fs::create_dir(&folder).expect("a folder");
    fs::set_permissions(&folder, Permissions::from_mode(0o700)).expect("its permissions");
    folder
}

/// The key of a client, whose files are these.
pub(super) fn key(folder: &Path, authority: &str) {
    let text = format!("tls = {{ authority = \"{authority}\" }}\n");
    write(folder, "key.toml", text);
}

/// An application that listens with a certificate of this name.
pub(super) fn listening(folder: &Path, certificate: &str) {
    write(folder, "small.pem", "");
    app(
        folder,
        &format!(
            "roots = [\"listener\"]\n[link]\nlisten = [\"tls/127.0.0.1:0\"]\n\
             tls = {{ certificate = \"{certificate}\", key = \"small.pem\", authority = \"small.pem\" }}\n\
             {PAIR}"
        ),
    );
}

/// An experiment with an axis of this many values.
pub(super) fn experiment(folder: &Path, axis: &str, count: usize) {
    let values = lines(count, |n| format!("\"{n} s\","));
    let text =
        format!("name = \"e\"\napplication = \"app.toml\"\nfor = \"1s\"\n[axes]\n{axis} = [{values}]\n");
    write(folder, "e.toml", text);
    app(folder, &format!("roots = [\"listener\"]\n{PAIR}"));
}
