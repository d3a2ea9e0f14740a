//! What only the SDK in C++ has: its own values, choices, and exceptions. A father in C++ has the same description and
//! behaves the same as one in Rust.

use std::path::Path;
use std::process::Command as Program;

use jde_abi::raw;
use jde_abi::read;
use jde_schema::bench::{Bench, Foreign};
use jde_schema::prelude::*;

use crate::foreign::{compile, include, load, open, output, run};

/// Where the doors are.
#[derive(Clone, Copy, Value)]
#[repr(C)]
#[value(name = "my_msgs/msg/Doors")]
struct Doors {
    /// In the frame of the base.
    places: Seq<Pose2D, 8>,
    /// Width of the narrowest.
    #[value(unit = "m")]
    narrowest: f64,
    /// Of the first four.
    #[value(unit = "m")]
    widths: [f32; 4],
    /// The building.
    building: Text<12>,
    /// Whether all are open.
    open: Flag,
    padding: Padding<3>,
    /// The floor.
    floor: i16,
    more_padding: Padding<2>,
    /// How many there are.
    count: u64,
}

/// How to go.
#[derive(Clone, Copy, Choice)]
#[repr(u8)]
enum Gait {
    Slow,
    VeryFast,
}

// The same as `tests/cpp/doors.cpp`.
#[derive(PortBundle)]
struct Manners {
    /// Whether it waits.
    #[modulation(default = true, was = "waits")]
    polite: Modulation<bool>,
    /// The floor.
    #[modulation(default = -1, min = -3.0, max = 9.0, fixed)]
    floor: Modulation<i16>,
}

/// Passes doors.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "10ms")]
struct Porter {
    /// Doors.
    #[import]
    doors: Import<Doors>,
    /// Wind.
    #[import(optional, unit = "m/s")]
    wind: Import<f64>,
    /// How to go.
    #[modulation(default = Gait::VeryFast)]
    gait: Modulation<Gait>,
    #[ports]
    manners: Manners,
    /// Doors that it passed.
    #[export]
    passed: Export<Doors>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
    /// Stops.
    #[child(group = "base")]
    brake: Child,
    /// Drives.
    #[child(group = "base", optional)]
    cruise: Child,
    /// Maps.
    #[child(perceptive)]
    map: Child,
    /// Any others.
    #[child(group = "others")]
    others: Children,
    /// Whether it hurries.
    #[modulates(child = "cruise")]
    hurry: Modulates<bool>,
}

/// Locks a door.
#[derive(Describe)]
#[schema(driver, period = "1s")]
struct Bolt {
    /// Where it is to be.
    #[command(neutral = 0.0, validity = "500ms", trigger, unit = "m")]
    #[expect(dead_code, reason = "only its description is compared")]
    place: Command<f64>,
}

impl Schema for Bolt {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

impl Schema for Porter {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let ready: Precondition = (self.doors.require(cx)?.count > 0).into();
        Ok(ready.urgency(if self.manners.polite.get(cx) {
            2.0
        } else {
            f64::INFINITY
        }))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let seen = self.doors.require(cx)?;
        let gait = match self.gait.get(cx) {
            Gait::Slow => "slow",
            Gait::VeryFast => "very fast",
        };
        let (count, building) = (seen.places.len(), seen.building.as_str());
        warn!(cx, "{}, {count} places in {building}, {gait}", cx.name());
        let mut loan = self.passed.loan(cx);
        *loan = *seen;
        loan.places
            .push(Pose2D::new(1.0, 2.0, 0.0))
            .map_err(|_| "too many places")?;
        loan.building = Text::new("annex");
        loan.open = Flag::TRUE;
        loan.publish_at(Duration::from_nanos(5));
        let speed = if self.wind.is_bound(cx) { 0.1 } else { 0.2 };
        let speed = speed * f64::from(self.manners.floor.get(cx));
        self.base.command(cx, Twist::planar(speed, 0.0));
        self.brake.wake(cx);
        self.cruise.wake(cx);
        self.others.wake(cx);
        self.map.wake(cx);
        self.hurry.set(cx, self.cruise.state(cx) == State::Winner);
        self.cruise
            .set_policy(cx, Policy::sticky(Duration::from_secs(1), 0.5));
        if self.brake.status(cx).is_some_and(|status| status.faulted) {
            self.map.sleep(cx);
        }
        Ok(())
    }
}

impl Arbitrate for Porter {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        if level.case() == Case::Collision && level.is_ready(&self.brake) {
            return Ok(Verdict::choose(&self.brake, "on overlap the brake wins"));
        }
        Ok(Verdict::nobody(".".repeat(126) + "é"))
    }
}

impl Inspect for Porter {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        if matches!(self.gait.get(cx), Gait::VeryFast) {
            problems.wrong(&self.gait, "it may not run");
        }
        problems.unavailable(&self.manners.polite, "nobody is there");
    }
}

/// What a porter does in a sequence of calls.
fn behaviour<S>(bench: &mut Bench<S>) -> Vec<String> {
    let mut seen = vec![format!("{:?}", bench.description())];
    seen.push(format!("{:?}", bench.inspect()));
    seen.push(format!("{:?}", bench.check()));
    seen.push(format!("{:?}", bench.iterate()));
    bench.set_real_time(false);
    seen.push(format!("{:?}", bench.awake()));
    let mut doors = Doors::zeroed();
    doors.count = 1;
    doors.narrowest = 0.8;
    doors.building = Text::new("hall");
    bench.import("doors", &doors);
    bench.set("gait", Gait::Slow);
    bench.name_children(&[
        ("brake", ""),
        ("cruise", ""),
        ("others", "one"),
        ("others", "two"),
    ]);
    for (wind, polite, state) in [(true, true, State::Winner), (false, false, State::Checking)] {
        if !wind {
            bench.unbind("wind");
        }
        bench.set("polite", polite);
        bench.set_faulted("brake", !polite);
        bench.set_child("cruise", state);
        seen.push(format!("{:?}", bench.check()));
        seen.push(format!("{:?}", bench.iterate()));
        let passed = bench.exported_in_place::<Doors>("passed").map(|passed| {
            (
                passed.places.to_vec(),
                passed.narrowest,
                passed.building,
                passed.open,
                passed.count,
            )
        });
        seen.push(format!("{passed:?} {:?}", bench.exported_at("passed")));
        let outputs = (
            bench.commanded::<Twist>("base"),
            bench.modulated::<bool>("cruise", "hurry"),
        );
        seen.push(format!(
            "{outputs:?} {:?} {:?}",
            bench.awake_children(),
            bench.policy("cruise")
        ));
    }
    bench.set_child("brake", State::Ready);
    bench.set_child("cruise", State::Winner);
    seen.push(format!("{:?}", bench.arbitrate("base")));
    bench.set_child("brake", State::Checking);
    bench.set_child("cruise", State::Checking);
    seen.push(format!("{:?}", bench.arbitrate("base")));
    seen.push(format!("{:?}", bench.log()));
    seen
}

#[test]
fn a_father_in_cplusplus_is_described_and_behaves_as_in_rust() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cpp/doors.cpp");
    let plugin = open(&compile(&source, "doors"));
    // SAFETY: the tables of a plugin that stays loaded.
    let (described, mut foreign): (_, Bench<Foreign>) = unsafe {
        let described = read::plugin(plugin).expect("the tables are valid");
        (
            described,
            Bench::foreign(&*(*plugin).schemas).expect("an instance"),
        )
    };
    let bolt = &described.schemas[1].ports;
    assert_eq!(*bolt, Bench::<Bolt>::new().description().ports);
    assert!(bolt[0].has(raw::TRIGGER), "R12");
    let in_rust = behaviour(&mut Bench::<Porter>::new());
    assert!(
        in_rust[2].contains("ready: false"),
        "R19: the doors have no value: {}",
        in_rust[2]
    );
    assert_eq!(behaviour(&mut foreign), in_rust);
}

#[test]
fn the_memory_of_a_build_in_cplusplus_has_the_form_of_rust() {
    // SAFETY: the table of a plugin that stays loaded.
    let mut foreign: Bench<Foreign> =
        unsafe { Bench::foreign(load("examples/cpp/counter.cpp")) }.expect("an instance");
    foreign.iterate().expect("no fault");
    let saved = foreign.save().expect("it saves");
    let mut in_rust = Bench::<Counter>::new();
    in_rust.restore(&saved).expect("it restores");
    assert_eq!(in_rust.schema().counted, 1);
    in_rust.iterate().expect("no fault");
    foreign
        .restore(&in_rust.save().expect("it saves"))
        .expect("it restores");
    foreign.iterate().expect("no fault");
    assert_eq!(foreign.exported("count"), Some(3_u32));
    let shorter = jde_schema::bench::Remembered {
        version: 1,
        bytes: saved.bytes[1..].to_vec(),
    };
    let refused = foreign.restore(&shorter).expect_err("it is damaged");
    assert_eq!(
        refused.reason,
        "a std_msgs/msg/UInt32 was to come, and nothing more was saved"
    );
}

/// Counts.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Counter {
    counted: u32,
}

impl Schema for Counter {
    fn iterate(&mut self, _: &Context) -> Result {
        self.counted += 1;
        Ok(())
    }
}

impl Memory for Counter {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&self.counted);
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        self.counted = saved.take()?;
        Ok(())
    }
}

#[test]
fn the_standard_types_in_cplusplus_equal_those_in_rust() {
    let header = std::fs::read_to_string(include().join("jde/types.hpp")).expect("the header exists");
    let names = header
        .lines()
        .filter_map(|line| line.strip_prefix("using ")?.split(' ').next());
    let ports = names
        .enumerate()
        .map(|(number, ty)| format!("    jde::Export<jde::{ty}> p{number}{{*this, \"p{number}\", \"\"}};\n"));
    let source = output("types.cpp");
    let text = format!(
        "#include <jde.hpp>\nstruct P : jde::Ports {{\n{}}};\nclass S : public jde::Perceptive<P> {{\npublic:\n    \
         static constexpr jde::About about() {{ return {{\"s\", \"S.\", jde::Nanoseconds(1)}}; }}\n    \
         void iterate(jde::Context &) override {{}}\n}};\nJDE_EXPORT_PLUGIN(\"s\", \"1\", \"S.\", S);\n",
        ports.collect::<String>()
    );
    std::fs::write(&source, text).expect("written");
    // SAFETY: the table of a plugin that stays loaded.
    let plugin = unsafe { read::plugin(open(&compile(&source, "types-cpp"))) }.expect("the tables are valid");
    let standard = jde_schema::types::standard();
    let ports = &plugin.schemas[0].ports;
    assert_eq!(ports.len(), standard.len());
    assert!(
        ports
            .iter()
            .zip(&standard)
            .all(|(port, ty)| port.value_type.same_as(ty))
    );
}

#[test]
fn a_library_needs_no_code_to_be_described() {
    let output = Program::new("nm")
        .arg("-C")
        .arg(compile(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cpp/doors.cpp"),
            "constant",
        ))
        .output()
        .expect("binutils is installed with the compiler");
    let symbols = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(symbols.contains(" jde_plugin"), "{symbols}");
    // Code that runs when the library is loaded, and variables that the system shares between libraries.
    for unwanted in ["_GLOBAL__sub_I", " u jde::", " u Porter"] {
        assert!(!symbols.contains(unwanted), "{unwanted}: {symbols}");
    }
}

#[test]
fn the_bench_in_cplusplus_passes_its_tests() {
    let program = output("bench-cpp");
    let warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"];
    run(Program::new("c++")
        .args(["-std=c++17", "-I"])
        .arg(include())
        .args(warnings)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cpp/bench.cpp"))
        .arg("-o")
        .arg(&program));
    run(&mut Program::new(program));
}

#[test]
fn the_headers_are_free_of_warnings_in_cplusplus_20() {
    for source in ["tests/cpp/doors.cpp", "examples/cpp/gauge.cpp"] {
        let warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"];
        run(Program::new("c++")
            .args(["-std=c++20", "-fsyntax-only", "-I"])
            .arg(include())
            .args(warnings)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(source)));
    }
}

#[test]
fn a_mistake_is_a_compile_error_in_words() {
    let port = |port: &str| format!("struct P : jde::Ports {{ {port} }};\n");
    let iterate = "void iterate(jde::Context &) override {}";
    for (ports, body, expected) in [
        (port("jde::Import<std::string> a{*this, \"a\", \"\"};"), iterate, "cannot be the type of a port"),
        (port("jde::Import<double> a{*this, \"a\", \"\", jde::fixed};"), iterate, "an import takes jde::trigger"),
        (
            port("jde::Modulation<double> a{*this, \"a\", \"\", -1.0, jde::min(0.0)};"),
            iterate,
            "the_default_of_a_modulation_is_outside_its_limits",
        ),
        (port("jde::Child a{*this, \"a\", \"\"};"), iterate, "a child has either a jde::group"),
        (port(""), "", "the schema does not say what it does"),
        (
            "struct V { char a; double b; };\nJDE_VALUE(V, \"m/msg/V\", \"\", JDE_MEMBER(a), JDE_MEMBER(b));\n".to_owned()
                + &port("jde::Import<V> a{*this, \"a\", \"\"};"),
            iterate,
            "a jde::Padding wherever the compiler would leave a gap",
        ),
    ] {
        let source = format!(
            "#include <jde.hpp>\n{ports}struct S : jde::Motor<P> {{\n    \
             static constexpr jde::About about() {{ return {{\"s\", \"S.\", jde::Nanoseconds(1)}}; }}\n    \
             {body}\n}};\nJDE_EXPORT_PLUGIN(\"s\", \"1\", \"S.\", S);\n"
        );
        let file = output("mistake.cpp");
        std::fs::write(&file, &source).expect("written");
        let compiled = Program::new("c++")
            .args(["-std=c++17", "-fsyntax-only", "-I"])
            .arg(include())
            .arg(&file)
            .output()
            .expect("a C++ compiler named c++ is installed");
        let words = String::from_utf8_lossy(&compiled.stderr);
        assert!(!compiled.status.success() && words.contains(expected), "{source}{words}");
    }
}
