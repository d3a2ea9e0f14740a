//! The step `packages`: installs the packages in a fresh Debian without Rust, runs what they contain, and
//! removes them without a trace. It packages the development build that the other steps use.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};

use super::{Form, make};
use crate::demo::digest;
use crate::lints;
use crate::prerequisites::INSTALL_DEBOOTSTRAP;
use crate::step::StepOutcome;
use crate::test::Context;
use crate::{project_files, shell};

/// The limit of each command in the fresh system: twenty times what the slowest takes.
const COMMAND_TIMEOUT: Duration = Duration::from_secs(600);

/// What `lintian` may find: nobody has asked Debian to accept the packages, and what it takes for a copy of libyaml is
/// one in Rust.
const ACCEPTED_TAGS: &str = "initial-upload-closes-no-bugs,embedded-library";

/// What the fresh system has beside a minimal Debian: what the documentation tells users of C, C++ and Python to install.
const INCLUDED_PACKAGES: &str = "cmake,g++,make,python3-pytest,python3-venv,xz-utils";

/// The demonstration, as a user without rights who has a folder of its own.
const DEMO: &str = "cd $(setpriv --reuid=65534 --clear-groups mktemp -d) && \
                    setpriv --reuid=65534 --regid=65534 --clear-groups $JDE demo --headless --lockstep --seed 1";

/// Programs that run an application, and one with a schema in Python, with the library of a prefix.
const PROGRAM: &str = "set -e
cd $(mktemp -d)
export PATH=$PREFIX/bin:$PATH
cc -o lockstep $PREFIX/share/jde/examples/embed/lockstep.c -I$PREFIX/include -L$PREFIX/lib -Wl,-rpath,$PREFIX/lib -ljde -lm
./lockstep $PREFIX/share/jde/apps/safe-navigation.toml
jde new schema shy --python
cat > shy.c << END
#include <jde_run.h>
#include <stdio.h>
int main(void)
{
    jde_application *application;
    jde_run *run;
    const jde_start_options options = {.size = sizeof options, .flags = JDE_LOCKSTEP};
    if (jde_application_load(\"shy/app.toml\", NULL, &application) != JDE_OK || jde_application_start(application, &options, &run) != JDE_OK ||
        jde_run_until_condition(run, \"shy.won\", 60.0) != JDE_OK || jde_run_close(run) != JDE_OK) {
        puts(jde_error());
        return 1;
    }
}
END
cc -o program shy.c -I$PREFIX/include -L$PREFIX/lib -Wl,-rpath,$PREFIX/lib -ljde -lm
./program";

/// What a user can do with the packages alone. Every application must be complete but for a gamepad, which this system lacks,
/// and a new one passes its tests.
const USE: &str = "set -e
for app in /usr/share/jde/apps/*.toml; do
    jde check $app > /dev/null 2> /var/tmp/problem ||
        grep -q 'no gamepad is connected' /var/tmp/problem || { cat /var/tmp/problem; exit 1; }
done
test -f /usr/share/man/man1/jde-run.1.gz
cd $(mktemp -d)
jde new app patrol && cd patrol && jde test";

/// Every program and library has its symbols, which name a line of the source.
const SYMBOLS: &str = "set -e
for file in /usr/bin/jde /usr/lib/jde/*.so /usr/lib/libjde.so.0 /usr/lib/python3/dist-packages/jde/_jde.abi3.so; do
    id=$(readelf --notes $file | sed -n 's/.*Build ID: //p')
    symbols=/usr/lib/debug/.build-id/${id%${id#??}}/${id#??}.debug
    address=$(nm $symbols | awk '/ t .*jde/ { print $1; exit }')
    addr2line -e $file $address | grep -q '[.]rs:[0-9]' || { echo $file has no lines; exit 1; }
done";

/// Schemas in each language but Rust, which this system lacks: built, tested and run as their READMEs say.
const SCHEMAS: &str = "set -e
cd $(mktemp -d)
for language in c cpp python; do
    jde new schema try-$language --$language
    cd try-$language
    if [ $language = python ]; then
        python3 -m pytest
    else
        cmake -B build > /dev/null && cmake --build build && ctest --test-dir build --output-on-failure
    fi
    jde run app.toml --lockstep --for 5s
    cd ..
done";

/// The wheel in an environment of its own, whose tools for tests are those of the system.
const INSTALL_WHEEL: &str = "set -e
python3 -m venv --system-site-packages /srv/jde
find /srv/jde ! -type d | sort > /var/tmp/before
/srv/jde/bin/pip install --no-index --no-cache-dir /*.whl";

const REMOVE_WHEEL: &str = "set -e
/srv/jde/bin/pip uninstall --yes jde-robot
find /srv/jde ! -type d | sort | diff /var/tmp/before -
rm --recursive /srv/jde";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("debootstrap").arg("--version")) {
        return context.missing_tool("debootstrap", INSTALL_DEBOOTSTRAP);
    }
    if shell::read(Command::new("id").arg("-u"))?.trim() != "0" {
        return Ok(StepOutcome::Skipped(
            "only root can make a root of its own".to_owned(),
        ));
    }
    let forms = [Form::Tarball, Form::Deb, Form::Wheel];
    let cargo = lints::build_all(context);
    let packages = make(&context.root, cargo, true, &forms, context.paint)?;
    let [archive, debs @ .., _] = &packages[..] else {
        unreachable!("there is a package of each form");
    };
    let mut lintian = Command::new("lintian");
    lintian
        .args(["--fail-on", "error,warning", "--suppress-tags", ACCEPTED_TAGS])
        .args(debs);
    shell::run(&mut lintian, context.paint)?;
    let system = FreshSystem::new(context)?;
    let before = system.files()?;
    for package in &packages {
        let name = package.file_name().context("a package has a name")?;
        fs::copy(package, system.root.join(name))?;
    }
    system.sh("dpkg --install /*.deb && dpkg --verify")?;
    let installed =
        digest(&system.sh(&DEMO.replace("$JDE", "jde"))?).context("the demonstration ended too soon")?;
    system.sh(USE)?;
    system.sh(SYMBOLS)?;
    let drives = |prefix: &str| {
        let driven = system.sh(&PROGRAM.replace("$PREFIX", prefix))?;
        ensure!(driven.contains("the robot is at"), "{driven}");
        Ok(())
    };
    drives("/usr")?;
    system.sh(SCHEMAS)?;
    system.sh("dpkg --purge jde-dbgsym libjde-dev libjde0 python3-jde jde")?;
    let is_same = |place: &str| {
        let drove = digest(&system.sh(&DEMO.replace("$JDE", &format!("{place}/bin/jde")))?);
        ensure!(
            drove.as_ref() == Some(&installed),
            "the program in {place} decides {drove:?}, not {installed}"
        );
        Ok(())
    };
    system.sh(INSTALL_WHEEL)?;
    is_same("/srv/jde")?;
    drives("/srv/jde")?;
    system.sh(&format!("PATH=/srv/jde/bin:$PATH\n{SCHEMAS}"))?;
    system.sh(REMOVE_WHEEL)?;
    // In one folder, and then in another.
    for folder in ["/opt", "/srv"] {
        system.sh(&format!(
            "tar --extract --xz --file /*.tar.xz --directory {folder}"
        ))?;
        let name = archive.file_name().unwrap_or_default().to_string_lossy();
        let place = format!("{folder}/{}", name.trim_end_matches(".tar.xz"));
        is_same(&place)?;
        system.sh(&format!("rm --recursive {place}"))?;
    }
    system.sh("rm /*.deb /*.tar.xz /*.whl")?;
    let after = system.files()?;
    let left: Vec<_> = before.symmetric_difference(&after).collect();
    ensure!(left.is_empty(), "the packages leave or take: {left:?}");
    fs::remove_dir_all(&system.root)?;
    context.discard(&context.target.join("package"))?;
    Ok(StepOutcome::Passed)
}

/// A Debian of its own, with compilers of C and C++ and with Python, and without Rust.
struct FreshSystem<'c> {
    context: &'c Context,
    root: PathBuf,
}

impl<'c> FreshSystem<'c> {
    /// Copies the system that the first trial has made. The name of its folder states what it contains.
    fn new(context: &'c Context) -> Result<Self> {
        let folder = context.target.join("package");
        let base = folder.join(format!("debian,{INCLUDED_PACKAGES}"));
        let root = folder.join("root");
        if !base.exists() {
            let release = fs::read_to_string("/etc/os-release")?;
            let name = release
                .lines()
                .find_map(|line| line.strip_prefix("VERSION_CODENAME="));
            let unfinished = folder.join("debian-unfinished");
            project_files::empty(&unfinished)?;
            let mut debootstrap = Command::new("debootstrap");
            debootstrap
                .arg("--variant=minbase")
                .arg(format!("--include={INCLUDED_PACKAGES}"))
                .arg(name.context("/etc/os-release names no release")?)
                .arg(&unfinished);
            shell::run(&mut debootstrap, context.paint)?;
            fs::rename(&unfinished, &base)?;
        }
        if root.exists() {
            fs::remove_dir_all(&root)?;
        }
        shell::read(Command::new("cp").arg("--archive").args([&base, &root]))?;
        Ok(Self { context, root })
    }

    /// Runs commands in the system, with processes and mounts of its own, which end with the commands. Returns what
    /// they print.
    fn sh(&self, commands: &str) -> Result<String> {
        let mut unshare = Command::new("unshare");
        unshare
            .args(["--mount", "--pid", "--fork", "--kill-child", "sh", "-c"])
            .arg("mount -t proc proc $0/proc && exec chroot $0 env --ignore-environment PATH=$PATH HOME=/ TMPDIR=/var/tmp sh -c \"$1\"")
            .args([self.root.as_os_str(), OsStr::new(commands)])
            .env("PATH", "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin");
        println!("{}", self.context.paint.dim(commands));
        let output = shell::read_within(&mut unshare, COMMAND_TIMEOUT)?;
        print!("{output}");
        Ok(output)
    }

    /// Returns all files but those of a package manager's records, and temporary ones.
    fn files(&self) -> Result<BTreeSet<String>> {
        let kept = "find / -xdev -path /proc -prune -o -path /var/tmp -prune -o -path /var/lib/dpkg -prune -o \
                    -path /var/log -prune -o -print";
        let mut chroot = Command::new("chroot");
        let files = shell::read(chroot.arg(&self.root).args(["sh", "-c", kept]))?;
        Ok(files.lines().map(str::to_owned).collect())
    }
}
