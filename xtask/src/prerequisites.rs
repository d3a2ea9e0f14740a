//! The programs and libraries that the machine needs besides Rust. If some are missing, the step prints the
//! commands that install them. It runs these commands only on request (`--install`), or as root in CI.

use std::process::Command;

use anyhow::{Result, bail};

use crate::disk_space;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

/// Something that the steps need, usually a program.
struct Tool {
    name: &'static str,
    /// A command that succeeds if the tool works.
    probe: &'static [&'static str],
    from: Origin,
}

#[derive(Clone, Copy)]
enum Origin {
    /// Packages of Debian and Ubuntu.
    Apt(&'static [&'static str]),
    /// A component of the Rust toolchain.
    Rustup(&'static str),
}

const TOOLS: &[Tool] = &[
    Tool {
        name: "a C and a C++ compiler",
        probe: &["sh", "-c", "cc --version && c++ --version"],
        from: Origin::Apt(&["gcc", "g++", "libc6-dev"]),
    },
    Tool {
        name: "CMake",
        probe: &["cmake", "--version"],
        from: Origin::Apt(&["cmake", "make"]),
    },
    Tool {
        name: "OpenCV and Eigen, for the examples in C++",
        probe: &[
            "sh",
            "-c",
            "ls /usr/include/opencv4/opencv2/imgproc.hpp /usr/include/eigen3/Eigen/Core",
        ],
        from: Origin::Apt(&["libopencv-imgproc-dev", "libeigen3-dev"]),
    },
    Tool {
        name: "valgrind",
        // It also needs the symbols of the dynamic linker: without them it cannot start any program.
        probe: &["valgrind", "--quiet", "true"],
        from: Origin::Apt(&["valgrind", "libc6-dbg"]),
    },
    Tool {
        name: "Python",
        // The clients of other projects import tkinter, though none of them opens a window.
        probe: &["python3", "-c", "import ensurepip, tkinter"],
        from: Origin::Apt(&["python3", "python3-venv", "python3-tk"]),
    },
    SCREEN,
    SLURM,
    Tool {
        name: "a Debian to install packages in",
        // The path of most users lacks the folder of debootstrap.
        probe: &[
            "sh",
            "-c",
            "PATH=$PATH:/usr/sbin; command -v debootstrap && command -v lintian && command -v dpkg-shlibdeps",
        ],
        from: Origin::Apt(&["debootstrap", "dpkg-dev", "lintian"]),
    },
    Tool {
        name: "rustfmt",
        probe: &["cargo", "fmt", "--version"],
        from: Origin::Rustup("rustfmt"),
    },
    Tool {
        name: "clippy",
        probe: &["cargo", "clippy", "--version"],
        from: Origin::Rustup("clippy"),
    },
];

/// The tools that the tests of windows need.
const SCREEN: Tool = Tool {
    name: "a screen without a monitor",
    // Windows are tested on a virtual screen and drawn by Mesa's software renderers, which need no graphics
    // card.
    probe: &[
        "sh",
        "-c",
        "command -v Xvfb && command -v xdotool && ls /usr/share/vulkan/icd.d/lvp_icd.*",
    ],
    from: Origin::Apt(&[
        "libegl1",
        "libgl1-mesa-dri",
        "libxcursor1",
        "libxi6",
        "libxkbcommon-x11-0",
        "mesa-vulkan-drivers",
        "xdotool",
        "xvfb",
    ]),
};

/// The daemons and commands of a cluster, with which experiments run as jobs.
const SLURM: Tool = Tool {
    name: "Slurm",
    // The path of most users lacks the folder of the daemons.
    probe: &[
        "sh",
        "-c",
        "PATH=$PATH:/usr/sbin; command -v slurmctld && command -v slurmd && command -v sbatch && command -v mungekey",
    ],
    from: Origin::Apt(&["slurm-wlm", "munge"]),
};

/// Returns whether this machine can run a Slurm cluster.
pub(crate) fn has_slurm() -> bool {
    SLURM.works()
}

/// Returns whether this machine can open windows.
pub(crate) fn has_screen() -> bool {
    SCREEN.works()
}

/// Installs missing tools if allowed; otherwise prints how to. Fails if a required tool is still
/// missing: in CI any tool, elsewhere the compilers of C and C++.
pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    // Too little room is not fatal: some steps need less, and cargo reports a full disk.
    match disk_space::warning(&context.target) {
        Ok(warning) => warning.iter().for_each(|warning| println!("{warning}")),
        Err(error) => println!("the free space on the disk is unknown: {error:#}"),
    }
    let missing: Vec<&Tool> = TOOLS.iter().filter(|tool| !tool.works()).collect();
    let privilege = Privilege::detect();
    let commands = installation(&missing, privilege);
    if may_install(context, privilege) {
        for command in &commands {
            // The check below decides; the exit status of the command does not matter.
            if let Err(error) = shell::run(&mut to_command(command), context.paint) {
                println!("{error:#}");
            }
        }
    } else if !commands.is_empty() {
        println!("missing tools are installed only with --install, which runs:");
        commands
            .iter()
            .for_each(|command| println!("    {}", command.join(" ")));
    }
    let missing: Vec<&Tool> = missing.into_iter().filter(|tool| !tool.works()).collect();
    for tool in &missing {
        println!("{} is missing: {}", tool.name, tool.how());
    }
    // The other tools are reported by the steps that need them. The tests need these compilers, for plugins in
    // C.
    let fatal: Vec<&str> = missing
        .iter()
        .filter(|tool| context.ci || tool.name == TOOLS[0].name)
        .map(|tool| tool.name)
        .collect();
    if !fatal.is_empty() {
        bail!("missing: {}", fatal.join(", "));
    }
    Ok(StepOutcome::Passed)
}

/// Returns whether the machine may be changed: with `--install`, or as root in CI.
fn may_install(context: &Context, privilege: Privilege) -> bool {
    context.options.install || (context.ci && privilege == Privilege::Root)
}

/// The command that installs valgrind, for the step that needs it.
pub(crate) const INSTALL_VALGRIND: &str = "sudo apt-get install valgrind libc6-dbg";

/// The command that installs what packages are made and tried with, for the step that needs it.
pub(crate) const INSTALL_DEBOOTSTRAP: &str = "sudo apt-get install debootstrap dpkg-dev lintian";

/// The command that installs Slurm, for the step that needs it.
pub(crate) const INSTALL_SLURM: &str = "sudo apt-get install slurm-wlm munge";

/// The rights of this user to install packages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Privilege {
    Root,
    /// `sudo` without a password.
    Sudo,
    None,
}

impl Privilege {
    fn detect() -> Self {
        if shell::read(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0") {
            Privilege::Root
        } else if shell::succeeds(Command::new("sudo").args(["-n", "true"])) {
            Privilege::Sudo
        } else {
            Privilege::None
        }
    }

    fn prefix(self) -> &'static [&'static str] {
        match self {
            Privilege::Root => &["env", "DEBIAN_FRONTEND=noninteractive"],
            Privilege::Sudo => &["sudo", "-n", "env", "DEBIAN_FRONTEND=noninteractive"],
            Privilege::None => &[],
        }
    }
}

/// Returns the commands that install the tools: one for all packages, one for all components.
fn installation(missing: &[&Tool], privilege: Privilege) -> Vec<Vec<&'static str>> {
    let mut packages = Vec::new();
    let mut components = Vec::new();
    for tool in missing {
        match tool.from {
            Origin::Apt(names) => packages.extend_from_slice(names),
            Origin::Rustup(component) => components.push(component),
        }
    }
    let mut commands = Vec::new();
    if !packages.is_empty() && privilege != Privilege::None {
        commands.push([privilege.prefix(), &["apt-get", "update", "-qq"]].concat());
        let install = ["apt-get", "install", "--yes", "-qq", "--no-install-recommends"];
        commands.push([privilege.prefix(), &install, &packages].concat());
    }
    if !components.is_empty() {
        commands.push([&["rustup", "component", "add"], components.as_slice()].concat());
    }
    commands
}

fn to_command(arguments: &[&str]) -> Command {
    let mut command = Command::new(arguments[0]);
    command.args(&arguments[1..]);
    command
}

impl Tool {
    fn works(&self) -> bool {
        shell::succeeds(&mut to_command(self.probe))
    }

    fn how(&self) -> String {
        match self.from {
            Origin::Apt(packages) => format!("sudo apt-get install {}", packages.join(" ")),
            Origin::Rustup(component) => {
                format!("rustup component add {component}, or the package of that name where Rust came from")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn commands(privilege: Privilege, names: &[&str]) -> Vec<String> {
        let missing: Vec<&Tool> = TOOLS.iter().filter(|tool| names.contains(&tool.name)).collect();
        installation(&missing, privilege)
            .iter()
            .map(|command| command.join(" "))
            .collect()
    }

    #[test]
    fn no_command_is_needed_if_no_tool_is_missing() {
        assert_eq!(commands(Privilege::Root, &[]), [""; 0]);
    }

    #[test]
    fn tools_are_installed_only_on_request_or_as_root_in_ci() {
        let may = |install, ci, privilege| may_install(&Context::of_a_test(install, ci), privilege);
        for privilege in [Privilege::Root, Privilege::Sudo, Privilege::None] {
            assert!(!may(false, false, privilege), "{privilege:?}");
            assert!(may(true, false, privilege), "{privilege:?}");
            assert!(may(true, true, privilege), "{privilege:?}");
        }
        assert!(may(false, true, Privilege::Root));
        assert!(!may(false, true, Privilege::Sudo));
        assert!(!may(false, true, Privilege::None));
    }

    #[test]
    fn packages_are_installed_by_one_command_without_questions() {
        let install = "env DEBIAN_FRONTEND=noninteractive apt-get install --yes -qq --no-install-recommends";
        assert_eq!(
            commands(Privilege::Sudo, &["a C and a C++ compiler", "valgrind"]),
            [
                "sudo -n env DEBIAN_FRONTEND=noninteractive apt-get update -qq".to_owned(),
                format!("sudo -n {install} gcc g++ libc6-dev valgrind libc6-dbg")
            ]
        );
    }

    #[test]
    fn components_are_installed_without_the_right_to_install_packages() {
        let commands = commands(Privilege::None, &["valgrind", "rustfmt", "clippy"]);
        assert_eq!(commands, ["rustup component add rustfmt clippy"]);
    }

    #[test]
    fn the_documented_commands_install_what_a_step_needs() {
        let how = |name| TOOLS.iter().find(|tool| tool.name == name).unwrap().how();
        assert_eq!(how("valgrind"), INSTALL_VALGRIND);
        assert_eq!(how("Slurm"), INSTALL_SLURM);
        assert_eq!(how("a Debian to install packages in"), INSTALL_DEBOOTSTRAP);
    }
}
