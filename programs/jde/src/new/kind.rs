//! The kinds of template, and the files of each. Kinds share the files that are the same in all.

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TemplateKind {
    /// A motor schema.
    Motor,
    /// A perceptive schema.
    Perceptive,
    /// A father of two children.
    Father,
    /// A driver of simulated hardware.
    Driver,
    /// A driver of a device at a serial line or behind TCP.
    Device,
    /// A motor schema in C++.
    MotorCpp,
    /// A perceptive schema in C++.
    PerceptiveCpp,
    /// A father of two children in C++.
    FatherCpp,
    /// A motor schema in C.
    MotorC,
    /// A motor schema in Python.
    MotorPython,
    /// A perceptive schema in Python.
    PerceptivePython,
    /// A father of two children in Python.
    FatherPython,
    /// Values that plugins share.
    Types,
    /// An application of existing schemas.
    Application,
}

/// A file of a template: its path, and its text.
type File = (&'static str, &'static str);

/// Includes the files of a folder of templates.
macro_rules! files {
    ($folder:literal: $($file:literal),+) => {
        &[$(($file, include_str!(concat!("../../templates/", $folder, "/", $file)))),+]
    };
}

const GIT: &[File] = &[(".gitignore", "/target\n")];
/// The same for a project of CMake, and the page about it.
const CMAKE: &[File] = &[
    (".gitignore", "/build\n"),
    ("README.md", include_str!("../../templates/cpp/README.md")),
];
/// The same for Python.
const GIT_PYTHON: &[File] = &[(".gitignore", "__pycache__/\n")];
/// The package of a plugin.
const PLUGIN: &[File] = &[(
    "Cargo.toml",
    include_str!("../../templates/plugin/Cargo.toml.txt"),
)];
/// The room of the simulator in which a schema is tried.
const ROOM: &[File] = files!("room": "world.toml");
const ABOUT: &[File] = files!("room": "README.md");
const MOTOR: &[File] = files!("motor": "src/lib.rs");
const PERCEPTIVE: &[File] = files!("perceptive": "src/lib.rs");
const FATHER: &[File] = files!("father": "src/lib.rs");
/// The applications of these schemas in any language.
const RUN_MOTOR: &[File] = files!("motor": "app.toml");
const RUN_PERCEPTIVE: &[File] = files!("perceptive": "app.toml");
const RUN_FATHER: &[File] = files!("father": "app.toml");
const DRIVER: &[File] = files!("driver": "src/lib.rs", "app.toml", "README.md");
const DEVICE: &[File] = files!(
    "device": "src/lib.rs", "src/session.rs", "src/emulator.rs", "examples/emulator.rs", "app.toml", "README.md"
);
const TYPES: &[File] = &[
    ("Cargo.toml", include_str!("../../templates/types/Cargo.toml.txt")),
    ("src/lib.rs", include_str!("../../templates/types/src/lib.rs")),
    ("README.md", include_str!("../../templates/types/README.md")),
];
/// A schema in C++: its template's header, plugin and test.
macro_rules! cpp {
    ($folder:literal) => {
        &[
            (
                "src/schema.hpp",
                include_str!(concat!("../../templates/", $folder, "/schema.hpp")),
            ),
            (
                "src/plugin.cpp",
                include_str!(concat!("../../templates/", $folder, "/plugin.cpp")),
            ),
            (
                "tests/schema.cpp",
                include_str!(concat!("../../templates/", $folder, "/test.cpp")),
            ),
        ]
    };
}
const CPP: &[File] = files!("cpp": "CMakeLists.txt");
const MOTOR_CPP: &[File] = cpp!("cpp-motor");
const PERCEPTIVE_CPP: &[File] = cpp!("cpp-perceptive");
const FATHER_CPP: &[File] = cpp!("cpp-father");
const MOTOR_C: &[File] = &[
    (
        "CMakeLists.txt",
        include_str!("../../templates/c-motor/CMakeLists.txt"),
    ),
    ("src/schema.c", include_str!("../../templates/c-motor/schema.c")),
    (
        "tests/schema.cpp",
        include_str!("../../templates/c-motor/test.cpp"),
    ),
];
/// A schema in Python: its template's file, test and application, which names the file.
macro_rules! python {
    ($folder:literal) => {
        &[
            (
                "__crate__.py",
                include_str!(concat!("../../templates/", $folder, "/schema.py")),
            ),
            (
                "test___crate__.py",
                include_str!(concat!("../../templates/", $folder, "/test.py")),
            ),
            (
                "app.toml",
                include_str!(concat!("../../templates/", $folder, "/app.toml")),
            ),
        ]
    };
}
const PYTHON: &[File] = files!("python": "README.md", "conftest.py");
const MOTOR_PYTHON: &[File] = python!("python-motor");
const PERCEPTIVE_PYTHON: &[File] = python!("python-perceptive");
const FATHER_PYTHON: &[File] = python!("python-father");
const APPLICATION: &[File] = files!(
    "app": "app.toml", "world.toml", "README.md", "tests/reaches-its-targets.toml", "tests/stops-before-a-box.toml"
);

impl TemplateKind {
    #[cfg(test)]
    pub(super) const ALL: [Self; 14] = [
        Self::Motor,
        Self::Perceptive,
        Self::Father,
        Self::Driver,
        Self::Device,
        Self::MotorCpp,
        Self::PerceptiveCpp,
        Self::FatherCpp,
        Self::MotorC,
        Self::MotorPython,
        Self::PerceptivePython,
        Self::FatherPython,
        Self::Types,
        Self::Application,
    ];

    /// The files of the template.
    pub(super) fn files(self) -> impl Iterator<Item = File> {
        let parts: &[&[File]] = match self {
            Self::Motor => &[GIT, PLUGIN, ABOUT, ROOM, MOTOR, RUN_MOTOR],
            Self::Perceptive => &[GIT, PLUGIN, ABOUT, ROOM, PERCEPTIVE, RUN_PERCEPTIVE],
            Self::Father => &[GIT, PLUGIN, ABOUT, ROOM, FATHER, RUN_FATHER],
            Self::MotorCpp => &[CMAKE, CPP, ROOM, MOTOR_CPP, RUN_MOTOR],
            Self::PerceptiveCpp => &[CMAKE, CPP, ROOM, PERCEPTIVE_CPP, RUN_PERCEPTIVE],
            Self::FatherCpp => &[CMAKE, CPP, ROOM, FATHER_CPP, RUN_FATHER],
            Self::MotorC => &[CMAKE, ROOM, MOTOR_C, RUN_MOTOR],
            Self::MotorPython => &[GIT_PYTHON, PYTHON, ROOM, MOTOR_PYTHON],
            Self::PerceptivePython => &[GIT_PYTHON, PYTHON, ROOM, PERCEPTIVE_PYTHON],
            Self::FatherPython => &[GIT_PYTHON, PYTHON, ROOM, FATHER_PYTHON],
            Self::Driver => &[GIT, PLUGIN, DRIVER],
            Self::Device => &[GIT, PLUGIN, DEVICE],
            Self::Types => &[GIT, TYPES],
            Self::Application => &[APPLICATION],
        };
        parts.iter().copied().flatten().copied()
    }

    /// The folders of the crates of jde on which the package depends.
    pub(super) fn crates(self) -> &'static [&'static str] {
        match self {
            Self::Motor | Self::Perceptive | Self::Father | Self::Driver => &["plugin/schema"],
            Self::Device => &["devices/device", "plugin/schema"],
            Self::Types => &["plugin/types"],
            Self::MotorCpp
            | Self::PerceptiveCpp
            | Self::FatherCpp
            | Self::MotorC
            | Self::MotorPython
            | Self::PerceptivePython
            | Self::FatherPython
            | Self::Application => &[],
        }
    }

    /// What the schema of a [`ROOM`] does, for its README.
    pub(super) fn about(self) -> &'static str {
        match self {
            Self::Motor | Self::MotorCpp | Self::MotorC | Self::MotorPython => {
                "A schema for jde: it drives towards an obstacle and stops in front of it."
            }
            Self::Perceptive | Self::PerceptiveCpp | Self::PerceptivePython => {
                "A perceptive schema for jde: it finds the nearest obstacle, and a motor schema turns the robot to it."
            }
            Self::Father | Self::FatherCpp | Self::FatherPython => {
                "A father for jde: it sends its children, the schemas `stop` and `goon`, back and forth."
            }
            Self::Driver | Self::Device | Self::Types | Self::Application => "",
        }
    }

    /// The folder in which the build puts a plugin.
    pub(super) fn build_folder(self) -> &'static str {
        match self {
            Self::MotorCpp | Self::PerceptiveCpp | Self::FatherCpp | Self::MotorC => "build",
            _ => "target/debug",
        }
    }

    /// The next commands for the user, in the new folder.
    pub(super) fn next_commands(self) -> &'static [&'static str] {
        match self {
            Self::Motor | Self::Perceptive | Self::Father => {
                &["cargo build", "cargo test", "__jde__ run app.toml"]
            }
            Self::MotorCpp | Self::PerceptiveCpp | Self::FatherCpp | Self::MotorC => &[
                "cmake -B build && cmake --build build",
                "ctest --test-dir build --output-on-failure",
                "__jde__ run app.toml",
            ],
            Self::MotorPython | Self::PerceptivePython | Self::FatherPython => {
                &["__python__ -m pytest", "__jde__ run app.toml"]
            }
            Self::Driver => &[
                "cargo build",
                "cargo test",
                "__jde__ run app.toml --log exercise=info",
            ],
            Self::Device => &["cargo build", "cargo test", "cargo run --example emulator"],
            Self::Types => &["cargo test"],
            Self::Application => &["__jde__ check app.toml", "__jde__ test", "__jde__ run app.toml"],
        }
    }
}
