//! Conformance of schemas in other languages: `stop` passes the same suite in Rust, C and C++, the examples in C
//! and C++ work, and the headers compile as C++ too.

#![allow(unsafe_code)]

mod cplusplus;
mod foreign;
mod suite;

use std::path::{Path, PathBuf};
use std::process::Command;

use jde_abi::read;
use jde_schema::bench::{Bench, Foreign, Remembered};
use jde_schema::panel::{Button, Color, Shape, Touch};
use jde_schema::prelude::*;

use foreign::{compile, include, load, open, output, run};

/// Brakes the base while an obstacle stands in a very close area ahead.
#[derive(Describe)]
#[schema(motor, period = "200ms")]
struct Stop {
    /// What the laser ahead sees.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// How far ahead the watched area reaches.
    #[modulation(default = 0.6, unit = "m", min = 0.0)]
    ahead: Modulation<f64>,
    /// Half the width of the watched area.
    #[modulation(default = 0.3, unit = "m", min = 0.0)]
    half_width: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

impl Schema for Stop {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(laser) = self.laser.get(cx) else {
            return Ok(false.into());
        };
        let nearest = laser.nearest_ahead(self.half_width.get(cx));
        Ok(nearest.is_some_and(|x| x <= self.ahead.get(cx)).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::ZERO);
        Ok(())
    }
}

#[test]
fn stop_in_rust_conforms() {
    suite::stop_conforms(const { &Stop::TABLE });
}

#[test]
fn stop_in_c_conforms() {
    suite::stop_conforms(load("tests/c/stop.c"));
}

#[test]
fn stop_in_cplusplus_conforms() {
    suite::stop_conforms(load("examples/cpp/stop.cpp"));
}

#[test]
fn a_host_refuses_what_the_contract_forbids() {
    // SAFETY: the table of a plugin that stays loaded.
    let mut bench: Bench<Foreign> = unsafe { Bench::foreign(load("tests/c/probe.c")) }.expect("an instance");
    bench.iterate().expect("every code is the expected one");
    assert_eq!(
        bench.exported_at("output"),
        Some(Duration::from_nanos(5)),
        "the last loan was not dropped"
    );
    assert_eq!(bench.awake_children(), ["motor"]);
}

#[test]
fn instances_of_the_examples_count_independently() {
    instances_count_independently("examples/c/counter.c");
    instances_count_independently("examples/cpp/counter.cpp");
}

fn instances_count_independently(source: &str) {
    let table = load(source);
    // SAFETY: the table of a plugin that stays loaded.
    let (mut first, mut second) = unsafe {
        (
            Bench::foreign(table).expect("an instance"),
            Bench::foreign(table).expect("an instance"),
        )
    };
    first.iterate().expect("no fault");
    first.set("step", 10_u32);
    first.iterate().expect("no fault");
    second.iterate().expect("no fault");
    assert_eq!(first.exported("count"), Some(11_u32));
    assert_eq!(
        second.exported("count"),
        Some(1_u32),
        "an instance changed the count of another"
    );
}

#[test]
fn an_instance_of_the_example_in_c_restores_the_count_of_another() {
    let table = load("examples/c/counter.c");
    // SAFETY: the table of a plugin that stays loaded.
    let (mut old, mut new) = unsafe {
        (
            Bench::foreign(table).expect("an instance"),
            Bench::foreign(table).expect("an instance"),
        )
    };
    old.iterate().expect("no fault");
    old.iterate().expect("no fault");
    let saved = old.save().expect("it saves");
    assert_eq!((saved.version, saved.bytes.len()), (1, 4));
    new.restore(&saved).expect("it restores");
    new.iterate().expect("no fault");
    assert_eq!(new.exported("count"), Some(3_u32));

    let other = Remembered { version: 2, ..saved };
    let refused = new.restore(&other).expect_err("the version differs");
    assert_eq!(refused.reason, "the saved count has another version or size");
}

/// The same as `examples/c/gauge.c`.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Gauge {
    /// The level, from 0 to 1.
    #[export]
    level: Export<f64>,
    height: f64,
    off: bool,
    mode: usize,
    mark: [f64; 2],
}

impl Schema for Gauge {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.level.write(cx, if self.off { 0.0 } else { self.height });
        Ok(())
    }
}

impl Panel for Gauge {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        pen.heading("Gauge");
        pen.value("level", self.height, "m");
        pen.row(|pen| {
            pen.button("empty", "Empty").enabled(self.height > 0.0);
            pen.toggle("on", "On", !self.off);
        });
        pen.slider("level", "Level", self.height, 0.0..=1.0, "m");
        pen.choice("mode", "Mode", ["slow", "fast"], self.mode);
        pen.table("table", ["what", "value"], [["level", "half"]]);
        // SAFETY: every pattern of bits is a valid value. The value is too large for the stack of a test.
        let mut image = unsafe { Box::<Image>::new_zeroed().assume_init() };
        (image.width, image.height, image.step) = (2, 2, 3);
        image.encoding = Text::new("mono8");
        image
            .data
            .extend_from_slice(&[0, 128, 9, 255, 64, 9])
            .expect("they fit");
        pen.image("image", &image);
        pen.plot("plot", "Level").axes("time, s", "level").show(|curves| {
            curves
                .curve("level", [(0.0, 0.0), (1.0, 0.5), (2.0, 0.25)])
                .ink(Ink::Accent);
        });
        pen.folded("more", "More", |pen| {
            pen.canvas("plane").forward_up().wants_clicks().show(|plane| {
                plane.rectangle((0.0, 0.0), (1.0, 1.0)).ink(Ink::Good);
                plane.arrow((0.0, 0.0), (1.0, 2.0)).ink(Ink::Bad);
                plane.disc(self.mark, 0.25).ink(Ink::Goal);
                plane.label(self.mark, "mark").ink(Ink::Goal);
                plane.robot(&Pose2D::new(1.0, 2.0, 0.5));
            });
        });
        pen.scene("space", "base_link").show(|space| {
            space
                .cuboid((0.0, 0.0, 0.5), [0.0, 0.0, 0.25], [1.0, 2.0, 3.0])
                .color(Color::Exact([0xff, 0x80, 0, 0x80]));
        });
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        if gesture.pressed("empty") {
            self.height = 0.0;
        } else if let Some(on) = gesture.toggled("on") {
            self.off = !on;
        } else if let Some(height) = gesture.moved("level") {
            self.height = height;
        } else if let Some(mode) = gesture.chose("mode") {
            self.mode = mode;
        } else if let Some([x, y, _]) = gesture.clicked("plane") {
            self.mark = [x, y];
            info!(cx, "{}", gesture.by());
        } else if matches!(gesture.touch, Touch::Key { .. }) {
            return Err("keys have no effect".into());
        }
        Ok(())
    }
}

#[test]
fn a_panel_in_c_draws_the_same_as_one_in_rust() {
    draws_the_same("examples/c/gauge.c");
}

#[test]
fn a_panel_in_cplusplus_draws_the_same_as_one_in_rust() {
    draws_the_same("examples/cpp/gauge.cpp");
}

fn draws_the_same(source: &str) {
    // SAFETY: the table of a plugin that stays loaded.
    let mut foreign = unsafe { Bench::foreign(load(source)) }.expect("an instance");
    let mut in_rust = Bench::<Gauge>::new();
    let at = [0.5, -1.5, 0.0];
    let button = Button::Primary;
    let key = "a".to_owned();
    let touches = [
        ("level", Touch::Moved(0.75)),
        ("mode", Touch::Chose(1)),
        ("plane", Touch::Clicked { at, button }),
        ("on", Touch::Toggled(false)),
        ("empty", Touch::Pressed),
        ("nothing", Touch::Pressed),
        ("plane", Touch::Key { key, down: true }),
    ];
    let mut results = Vec::new();
    for (widget, touch) in touches {
        let outcome = in_rust.touch(widget, touch.clone());
        assert_eq!(foreign.touch(widget, touch), outcome, "{widget}");
        foreign.iterate().expect("no fault");
        in_rust.iterate().expect("no fault");
        assert_eq!(foreign.exported::<f64>("level"), in_rust.exported("level"));
        let drawn = foreign.draw().expect("no fault");
        assert_eq!(drawn, in_rust.draw().expect("no fault"), "{widget}");
        results.push((drawn, outcome.is_ok()));
    }
    assert_eq!(foreign.log(), in_rust.log());
    assert_eq!(results[0].0.slider("level"), 0.75);
    assert_eq!(results[1].0.chosen("mode"), "fast");
    assert!(!results[3].0.is_on("on") && results[3].0.can_press("empty"));
    assert!(!results[4].0.can_press("empty"));
    let (shapes, ok) = (results[6].0.shapes("plane"), results[6].1);
    assert!(shapes.iter().any(|shape| matches!(
        shape,
        Shape::Circle {
            center: [0.5, -1.5],
            ..
        }
    )));
    assert!(!ok, "the failure of a gesture is not reported");
}

#[test]
fn a_panel_in_c_compiles_as_cplusplus() {
    run(Command::new("c++")
        .args([
            "-std=c++11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-fsyntax-only",
        ])
        .arg("-I")
        .arg(include())
        .args(["-x", "c++"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/c/gauge.c")));
}

#[test]
fn the_standard_types_in_c_equal_those_in_rust() {
    let plugin = compile(&write_types_plugin(), "types");
    // SAFETY: the table of a plugin that stays loaded.
    let plugin = unsafe { read::plugin(open(&plugin)) }.expect("the tables are valid");
    let ports = &plugin.schemas[0].ports;
    let standard = jde_schema::types::standard();
    assert_eq!(ports.len(), standard.len());
    for (port, ty) in ports.iter().zip(&standard) {
        assert!(port.value_type.same_as(ty), "{} differs", ty.name);
        assert_eq!(&*port.value_type, ty, "the comments differ");
    }
}

#[test]
fn the_headers_compile_as_cplusplus() {
    let source = output("cplusplus.cc");
    std::fs::write(
        &source,
        "#include \"jde_types.h\"\nstatic const jde_port ports[] = {JDE_PORT_EXPORT(\"a\", \"\", jde_twist_type)};\n\
         static const jde_schema schemas[] = {{sizeof(jde_schema), JDE_DRIVER, \"a\", \"\", 1, 0, ports, nullptr, 1, 0, \
         nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr}};\n\
         JDE_PLUGIN(\"a\", \"1\", \"\", schemas);\n",
    )
    .expect("written");
    run(Command::new("c++")
        .args([
            "-std=c++11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-fsyntax-only",
        ])
        .arg("-I")
        .arg(include())
        .arg(source));
}

/// Writes a plugin in C that exports a variable of each standard type, in the order of the header.
fn write_types_plugin() -> PathBuf {
    let mut ports = String::new();
    let header = std::fs::read_to_string(include().join("jde_types.h")).expect("the header exists");
    let descriptions = header
        .lines()
        .filter_map(|line| line.strip_prefix("static const jde_type ")?.strip_suffix(" = {"));
    for (number, ty) in descriptions.enumerate() {
        ports += &format!("JDE_PORT_EXPORT(\"p{number}\", \"\", {ty}),\n");
    }
    let text = format!(
        "#include \"jde_types.h\"\n\
         static const jde_port ports[] = {{{ports}}};\n\
         static void *create(const jde_schema *s, const jde_host *h, jde_context *c) {{ (void)s; (void)h; (void)c; return NULL; }}\n\
         static int32_t iterate(void *i, jde_context *c) {{ (void)i; (void)c; return JDE_OK; }}\n\
         static const jde_schema schemas[] = {{{{sizeof(jde_schema), JDE_DRIVER, \"types\", \"\", 1u, 0u, ports, NULL, \
         JDE_COUNT(ports), 0u, create, NULL, NULL, NULL, iterate, NULL, NULL, NULL}}}};\n\
         JDE_PLUGIN(\"types\", \"1\", \"\", schemas);\n"
    );
    let path = output("types.c");
    std::fs::write(&path, text).expect("written");
    path
}
