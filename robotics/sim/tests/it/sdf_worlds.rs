//! Worlds in SDF: their things stand where libsdformat puts them, and what is left out is named.

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::{Path, PathBuf};

use jde_sim::{ImportedWorld, World, WorldError};
use proptest::prelude::*;

pub(crate) const BOX: &str =
    "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>";

/// Writes files for one test, and converts the first.
pub(crate) fn import_with(
    folder: &str,
    files: &[(&str, &str)],
    models: &[PathBuf],
) -> Result<ImportedWorld, WorldError> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sdf").join(folder);
    for (name, text) in files {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }
    let [world] = <[_; 1]>::try_from(jde_sim::import(&folder.join(files[0].0), models, "lab")?).unwrap();
    Ok(world)
}

fn import(name: &str, text: &str) -> Result<ImportedWorld, WorldError> {
    import_with("one", &[(name, text)], &[])
}

/// Converts the world with these contents.
fn import_world(name: &str, version: &str, body: &str) -> ImportedWorld {
    let text = format!("<sdf version='{version}'><world name='w'>{body}</world></sdf>");
    import(name, &text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

pub(crate) fn faults(name: &str, text: &str) -> Vec<String> {
    let error = import(name, text).expect_err("the file has faults");
    let faults = error.faults().iter();
    faults
        .map(|fault| format!("{}: {}", fault.line().unwrap_or_default(), fault.message))
        .collect()
}

fn world(imported: &ImportedWorld) -> World {
    World::parse(&imported.text, PathBuf::from("imported.toml"), 1)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.text))
}

pub(crate) fn report(imported: &ImportedWorld) -> Vec<String> {
    imported.report().collect()
}

/// Returns the x and y of the middles of the boxes, mm.
pub(crate) fn boxes(imported: &ImportedWorld) -> Vec<[i64; 2]> {
    let centers = imported
        .text
        .lines()
        .filter_map(|line| line.strip_prefix("center = [")?.strip_suffix(']'));
    let millimetres = |number: &str| (number.parse::<f64>().unwrap() * 1000.0).round() as i64;
    let pair = |center: &str| {
        center
            .split_once(", ")
            .map(|(x, y)| [millimetres(x), millimetres(y)])
            .unwrap()
    };
    centers.map(pair).collect()
}

const SDF: &str = r#"<?xml version="1.0"?>
<sdf version="1.6">
  <world name="lab">
    <include><uri>model://sun</uri></include>
    <model name="floor"><link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
    <model name="shelf">
      <pose>1 2 0 0 0 1.5707963267948966</pose>
      <link name="l">
        <pose>1 0 0.5 0 0 0</pose>
        <collision name="c"><geometry><box><size>2 1 1</size></box></geometry></collision>
      </link>
    </model>
    <model name="pillar">
      <pose>9 9 0.5 0 0 0</pose>
      <link name="l"><collision name="c"><geometry><cylinder><radius>0.2</radius><length>1</length></cylinder></geometry></collision></link>
    </model>
    <model name="lamp">
      <pose>0 0 2 0 0 0</pose>
      <link name="l"><collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
    </model>
    <model name="ramp">
      <link name="l"><collision name="c"><pose>0 0 0 0 0.3 0</pose><geometry><box><size>1 1 1</size></box></geometry></collision></link>
    </model>
    <model name="chair">
      <link name="l"><collision name="c"><geometry><mesh><uri>chair.dae</uri></mesh></geometry></collision></link>
    </model>
    <state world_name="lab"><model name="pillar"><pose>5 0 0.5 0 0 0</pose></model></state>
  </world>
</sdf>"#;

#[test]
fn the_things_of_a_world_stand_where_it_puts_them_and_the_others_are_named() {
    let imported = import("lab.sdf", SDF).unwrap();
    assert_eq!(
        report(&imported),
        [
            "3 things could move in Gazebo, and are fixed: `shelf` is one.",
            "One thing is not upright: the outline up to 0.5 m above the floor is in the world (1: `ramp`).",
            "a mesh of `chair` is left out: meshes are not converted: draw what a robot meets of it as `[[walls]]` or \
             `[[boxes]]` (line 25)",
            "a sphere of `lamp` is left out: it is 1.90 m above the floor (line 19)",
        ]
    );
    let world = world(&imported);
    // The shelf, the pillar and four sides of the ramp.
    assert_eq!((world.name(), world.shapes().count()), ("lab", 6));
    // The pillar stands where the saved state has it.
    let pillar = world.cast_ray([3.0, 0.0], 0.0, 10.0, None);
    assert!((pillar.unwrap() - 1.8).abs() < 1e-9, "{pillar:?}");
    // The shelf is turned to the left: its centre is one metre to the left of its model, its long side along y.
    let (side, end) = (
        world.cast_ray([-2.0, 3.0], 0.0, 10.0, None),
        world.cast_ray([1.0, 0.6], FRAC_PI_2, 10.0, None),
    );
    assert!((side.unwrap() - 2.5).abs() < 1e-6, "{side:?}");
    assert!((end.unwrap() - 1.4).abs() < 1e-6, "{end:?}");
}

/// The numbers are those of libsdformat 12.3.
#[test]
fn poses_are_those_of_libsdformat() {
    let model =
        |pose: &str, inside: &str| format!("<model name='m'>{pose}<link name='l'>BOX</link>{inside}</model>");
    let offset = "<link name='k'><pose frame='l'>2 0 0 0 0 0</pose>BOX</link>";
    let shifted = "<link name='k'>BOX</link><frame name='f'><pose>0 5 0 0 0 0</pose></frame>";
    let shifted = shifted.replace(
        "BOX",
        &BOX.replace("<geo", "<pose relative_to='f'>0 0 .1 0 0 0</pose><geo"),
    );
    let turned = "<frame name='f'><pose>1 1 0 0 0 1.5707963</pose></frame>";
    let placed = "<frame name='f' attached_to='m::l'><pose>1 1 0 0 0 1.5707963</pose></frame>\
        <model name='m'><pose>3 0 0 0 0 0</pose><link name='l'><pose>0 1 0 0 0 0</pose></link></model>\
        <model name='n' placement_frame='b'><pose relative_to='f'/>\
        <link name='a'>BOX</link><link name='b'><pose>0 0 1 1.57 0 0</pose>BOX</link></model>";
    let flat = "<model name='m'><frame name='a::__model__' attached_to='a::l'>\
        <pose relative_to='__model__'>1 2 0 0 0 0.5</pose></frame>\
        <link name='a::l'><pose relative_to='a::__model__'>1 0 0 0 0 0</pose>BOX</link>\
        <joint name='j' type='fixed'><parent>world</parent><child>a::l</child><pose>1 0 0 0 0 0</pose></joint>\
        <link name='z'><pose relative_to='j'>0 0 .4 0 0 0</pose>BOX</link></model>";
    let nested = "<model name='m'><pose>1 0 0 0 0 1.5707963</pose><link name='l'/>\
        <model name='n'><pose relative_to='l'>1 0 0 0 0 0</pose><link name='k'><pose>0 1 0 0 0 0</pose>BOX</link></model></model>\
        <model name='o'><pose relative_to='m::n::k'>1 0 0 0 0 0</pose><link name='l'>BOX</link></model>";
    let quarter = "<pose rotation_format='quat_xyzw'>1 2 0 0 0 2 2</pose>";
    let cases = [
        (
            "1.6",
            model("<pose><!-- x y z r p y -->3 4 0.5 0 0 0</pose>", ""),
            vec![[3000, 4000]],
        ),
        (
            "1.9",
            model("<pose degrees='1'>1 2 0 0 0 90</pose>", ""),
            vec![[1000, 2000]],
        ),
        (
            "1.9",
            model("<pose degrees='True'>\n1\t2 0\n0 0 90 </pose>", ""),
            vec![[1000, 2000]],
        ),
        ("1.9", model(quarter, ""), vec![[1000, 2000]]),
        (
            "1.9",
            model("<pose>1x 2,5 +.3e0 0 0 0</pose><pose>9 9 9 9 9 9</pose>", ""),
            vec![[1000, 2000]],
        ),
        ("1.9", model("<pose> </pose>", ""), vec![[0, 0]]),
        (
            "1.9",
            model("<pose frame='f'>1 2 0 0 0 0</pose>", ""),
            vec![[1000, 2000]],
        ),
        (
            "1.5",
            model("<pose frame='world'/>", offset),
            vec![[0, 0], [2000, 0]],
        ),
        (
            "1.9",
            turned.to_owned() + &model("<pose relative_to='f'>1 0 0 0 0 0</pose>", ""),
            vec![[1000, 2000]],
        ),
        ("1.9", model("", &shifted), vec![[0, 0], [0, 5000]]),
        ("1.9", placed.to_owned(), vec![[5000, 2000], [4000, 2000]]),
        ("1.7", flat.to_owned(), vec![[1878, 2479], [2755, 2959]]),
        ("1.9", nested.to_owned(), vec![[0, 1000], [0, 2000]]),
    ];
    for (version, body, right) in cases {
        let imported = import_world("pose.sdf", version, &body.replace("BOX", BOX));
        assert_eq!(boxes(&imported), right, "{body}\n{}", imported.text);
        world(&imported);
    }
}

#[test]
fn shapes_are_those_of_libsdformat() {
    let shape = |shape: &str| {
        let collision =
            format!("<collision><pose>0 0 .2 0 0 0</pose><geometry>{shape}</geometry></collision>");
        import_world(
            "shape.sdf",
            "1.11",
            &format!("<model name='m'><static>1</static><link>{collision}</link></model>"),
        )
    };
    let triangle =
        "<polyline><point>0 0</point><point>2 0</point><point>0 1</point><height>1</height></polyline>";
    for (text, right) in [
        ("<box><size>1 2 0.5 7</size></box>", "size = [1, 2]"),
        ("<box/>", "size = [1, 1]"),
        (
            "<cylinder><radius>0.3</radius></cylinder>",
            "radius = 0.3\nheight = 0.7",
        ),
        (
            "<capsule><radius>0.3</radius><length>1</length></capsule>",
            "radius = 0.3\nheight = 1",
        ),
        (
            "<cone><radius>0.4</radius><length>0.4</length></cone>",
            "radius = 0.4\nheight = 0.4",
        ),
        (triangle, "points = [[0, 0], [2, 0], [0, 1]]"),
    ] {
        let imported = shape(text);
        assert!(imported.text.contains(right), "{text}: {}", imported.text);
        world(&imported);
    }
    for (text, right) in [
        (
            "<box><size>1 -1 1</size></box>",
            "a box of `m` is left out: its size is not above 0 (line 1)",
        ),
        (
            "<heightmap/>",
            "a heightmap of `m` is left out: a floor is level (line 1)",
        ),
        ("<torus/>", "a torus of `m` is left out: it is not known (line 1)"),
        (
            "<plane><normal>1 0 0</normal></plane>",
            "a plane of `m` is left out: it is not level (line 1)",
        ),
    ] {
        let imported = shape(text);
        assert_eq!(report(&imported)[1..], [right], "{text}");
        world(&imported);
    }
}

#[test]
fn files_are_read_as_tinyxml2_reads_them() {
    let model =
        |name: &str| format!("<model name='{name}'><static>1</static><link name='l'>{BOX}</link></model>");
    let m = model("m");
    for text in [
        format!(
            "<sdf version='1.9'><world name='w'>{}</world></sdf>",
            model("a&b")
        ),
        format!("<?xml version='1.0'?><!-- a -- b ---><sdf><plugin><gz::x>1</gz::x></plugin>{m}</sdf> end"),
        format!("\u{feff}\r\n<sdf><world name='w'><gz:x gz:y='1'/>{m}</world></sdf>"),
        format!("<!DOCTYPE sdf><a/><sdf><world name='&quot;&unknown;'>{m}</world></sdf>"),
    ] {
        let imported = import("lenient.sdf", &text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(boxes(&imported), [[0, 0]], "{text}");
        world(&imported);
    }
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin.sdf");
    let text = format!(
        "<?xml version='1.0' encoding='ISO-8859-1'?><sdf>{}</sdf>",
        model("caf\u{e9}")
    );
    fs::write(&file, text.chars().map(|letter| letter as u8).collect::<Vec<_>>()).unwrap();
    assert!(
        jde_sim::import(&file, &[], "lab").unwrap()[0]
            .text
            .contains("caf\u{e9}")
    );
}

#[test]
fn populations_stand_where_gazebo_puts_them_and_actors_are_named() {
    let converted = |distribution: &str| {
        let model = format!(
            "<model name='can'><static>1</static><pose>9 9 9 0 0 0</pose><link name='l'>{BOX}</link></model>"
        );
        let region = "<pose>1 2 0 0 0 0</pose><box><size>4 6 0.01</size></box><model_count>4</model_count>";
        let inside = format!("{model}{region}<distribution>{distribution}</distribution>");
        import_world(
            "population.sdf",
            "1.6",
            &format!("<population name='pop'>{inside}</population>\n<actor name='walker'/>"),
        )
    };
    let grid = converted("<type>grid</type><rows>3</rows><cols>2</cols><step>1 2 0</step>");
    assert_eq!(
        boxes(&grid),
        [
            [500, 0],
            [1500, 0],
            [500, 2000],
            [1500, 2000],
            [500, 4000],
            [1500, 4000]
        ]
    );
    let actor = "<actor> `walker` is left out: a conversion makes nothing that moves: add it as one of `[[people]]` or \
         `[[movers]]` (line 2)";
    assert_eq!(report(&grid), [actor]);
    let line = boxes(&converted("<type>linear-x</type>"));
    assert_eq!(line, [[-1000, 2000], [0, 2000], [1000, 2000], [2000, 2000]]);
    let drawn = boxes(&converted("<type>random</type>"));
    let is_inside = |[x, y]: &[i64; 2]| (-1000..3000).contains(x) && (-1000..5000).contains(y);
    assert!(drawn.len() == 4 && drawn.iter().all(is_inside), "{drawn:?}");
    let unknown = "<population> `pop` is left out: its distribution `heap` is not known (line 1)".to_owned();
    let reasons = report(&converted("<type>heap</type>"));
    assert!(reasons.contains(&unknown), "{reasons:?}");
}

#[test]
fn an_empty_world_has_room_for_robots_and_bounds_contain_what_is_left_out() {
    let imported = import("nothing.sdf", "<sdf>\n<world name='w'/></sdf>").unwrap();
    assert_eq!(
        report(&imported),
        ["Nothing that stands on the floor is converted: the world is empty."]
    );
    assert!(world(&imported).bounds().contains([-2.0, -0.5]));
    let mesh = "<model name='wall'><link name='l'><pose>20 -30 0 0 0 0</pose>\
        <collision name='c'><geometry><mesh/></geometry></collision></link></model>";
    assert!(
        world(&import_world("mesh.sdf", "1.9", mesh))
            .bounds()
            .contains([20.0, -30.0])
    );
}

#[test]
fn everything_that_is_not_understood_is_named_with_its_line() {
    let text = format!(
        "<sdf><world name='w'>\n<physics/>\n<gui/>\n<light/>\n<light/>\n<model name='m'><static>1</static>\n<plugin/>\n\
         <link name='l'>{BOX}<sensor/>\n<foo/><gz:bar/></link>\n<joint name='j'><child>l</child></joint>\n\
         <link name='k'><pose relative_to='nowhere'/>\n{BOX}</link></model></world>\n<world name='other'/>\n<model name='beside'/></sdf>"
    );
    assert_eq!(
        report(&import("named.sdf", &text).unwrap()),
        [
            "<foo> is left out: it is not known (line 9)",
            "<gui> is left out: it is about the windows of Gazebo (line 3)",
            "<gz:bar> is left out: it is an extension of another program (line 9)",
            "<joint> is left out: nothing moves at a joint (line 10)",
            "<light> is left out: it is only seen, and stops nothing (line 4, and 1 more)",
            "<model> `beside` is left out: a file becomes one world, the first in it (line 14)",
            "<physics> is left out: the simulator has its own physics (line 2)",
            "<plugin> is left out: it is a program of Gazebo (line 7)",
            "<sensor> is left out: an application chooses its robots and their sensors (line 8)",
            "<world> `other` is left out: a file becomes one world, the first in it (line 13)",
            "`m` is left out: its pose is relative to `nowhere`, which is not there (line 12)",
        ]
    );
}

#[test]
fn faults_of_an_sdf_world_have_their_lines() {
    let model = |inside: &str| format!("<sdf>\n<model name='m'>\n{inside}\n</model>\n</sdf>");
    let pose = |pose: &str| faults("wrong.sdf", &model(pose));
    for numbers in ["1 2 3", "1 2 3 4 5 6 7", "1 2 3 4 5 x", "1 2 3 4 5 1e999"] {
        let expected = "3: the pose of `m` is wrong: expected x y z roll pitch yaw";
        assert_eq!(pose(&format!("<pose>{numbers}</pose>")), [expected], "{numbers}");
    }
    let flag = "3: the pose of `m` is wrong: expected `degrees` to be true or false";
    assert_eq!(pose("<pose degrees='yes'>1 2 3 4 5 6</pose>"), [flag]);
    let flat = "<link><collision><geometry><box><size>1 1</size></box></geometry></collision></link>";
    let size = "3: the size of `m` is wrong: expected 3 numbers, in metres";
    assert_eq!(faults("size.sdf", &model(flat)), [size]);
    assert_eq!(
        faults("page.sdf", "<html/>"),
        ["1: `html` is no SDF: expected <sdf>"]
    );
    assert_eq!(
        faults("cut.sdf", "<sdf>\n<world>"),
        ["2: `<world>` is not closed"]
    );
    let template = "1: it is a template (ERB): write `erb FILE > NEW.sdf`, and convert the new file";
    assert_eq!(
        faults("world.sdf.erb", "<%\n# a template\n%>\n<sdf/>"),
        [template]
    );
    let absent = jde_sim::import(Path::new("absent.sdf"), &[], "lab").expect_err("there is no such file");
    assert!(absent.to_string().contains("absent.sdf"), "{absent}");
}

proptest! {
    #[test]
    fn no_name_of_an_sdf_world_spoils_the_text(name in "[^<&\\x00-\\x1f]{0,12}") {
        let name = name.replace('\'', "&apos;");
        let text = SDF.replace("'lab'", "x").replace("\"shelf\"", &format!("'{name}'"));
        if let Ok(imported) = import("named.sdf", &text) {
            world(&imported);
        }
    }

    #[test]
    fn cut_files_are_refused_or_converted(end in 0usize..SDF.len()) {
        prop_assume!(SDF.is_char_boundary(end));
        let _ = import("part.sdf", &SDF[..end]);
    }
}
