//! Worlds of this and of other programs, robots, and the logs of robots.

use std::fs;
use std::path::Path;

use super::files::{add_packed, app, lines, write};

/// A grid of as many models as a population may have.
pub(super) const GRID: &str = "<type>grid</type><rows>999999999</rows><cols>999999999</cols>";

/// Writes an application with a robot in a world `w.toml`.
pub(super) fn simulated(folder: &Path) {
    app(
        folder,
        "roots = [\"a\"]\n[schemas.a]\ntype = \"sim/robot\"\nworld = \"w.toml\"\n",
    );
}

/// A world of this text, and a robot in it.
pub(super) fn world(folder: &Path, text: &str) {
    write(folder, "w.toml", text);
    simulated(folder);
}

/// A file of SDF whose world has these parts.
pub(super) fn sdf(folder: &Path, parts: &str) {
    write(
        folder,
        "w.sdf",
        format!("<sdf version='1.9'><world name='w'>{parts}</world></sdf>"),
    );
}

/// Models that contain each other, and things that are in nothing.
pub(super) fn nested_sdf(folder: &Path, name: &str, levels: usize) {
    let (open, close) = (format!("<{name} name='a'>"), format!("</{name}>"));
    sdf(
        folder,
        &format!("{}{}", open.repeat(levels), close.repeat(levels)),
    );
}

/// A population of a thousand millions, in a form.
pub(super) fn population(folder: &Path, distribution: &str) {
    let model = "<model name='m'><link name='l'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry>\
        </collision></link></model>";
    sdf(
        folder,
        &format!(
            "<population name='p'>{model}<model_count>999999999</model_count><box><size>9 9 9</size></box>\
             <distribution>{distribution}</distribution></population>"
        ),
    );
}

/// Models that include two of the next each.
pub(super) fn doubled_includes(folder: &Path) {
    let include = |n: usize| format!("<include><uri>model://m{n}</uri></include>");
    for number in 0..40 {
        let model = folder.join(format!("m{number}"));
        fs::create_dir(&model).expect("a folder");
        let parts = include(number + 1).repeat(2);
        write(
            &model,
            "model.sdf",
            format!("<sdf version='1.9'><model name='m'>{parts}</model></sdf>"),
        );
        let config = "<model><name>m</name><sdf version='1.9'>model.sdf</sdf></model>";
        write(&model, "model.config", config);
    }
    sdf(folder, &include(0));
}

/// A model that includes itself and the one that includes it.
pub(super) fn included_by_itself(folder: &Path) {
    for (number, other) in [(0, 1), (1, 0)] {
        let model = folder.join(format!("m{number}"));
        fs::create_dir(&model).expect("a folder");
        let parts = [other, number].map(|n| format!("<include><uri>model://m{n}</uri></include>"));
        let parts = parts.concat().repeat(3000);
        write(
            &model,
            "model.sdf",
            format!("<sdf version='1.9'><model name='m'>{parts}</model></sdf>"),
        );
        let config = "<model><name>m</name><sdf version='1.9'>model.sdf</sdf></model>";
        write(&model, "model.config", config);
    }
    sdf(folder, "<include><uri>model://m0</uri></include>");
}

/// Two hundred thousand actors.
pub(super) fn elements(folder: &Path) {
    sdf(
        folder,
        &lines(200_000, |n| {
            format!("<actor name='a{n}'><pose>1 2 3 4 5 6</pose></actor>")
        }),
    );
}

/// A polyline with 300,000 points, and a heightmap that is a device.
pub(super) fn outline(folder: &Path) {
    let points = lines(300_000, |n| format!("<point>{n} {}</point>", n % 7));
    let shape = |shape: &str| format!("<collision name='c'><geometry>{shape}</geometry></collision>");
    let outline = shape(&format!("<polyline>{points}<height>1</height></polyline>"));
    let heights = shape("<heightmap><uri>/dev/zero</uri></heightmap>");
    sdf(
        folder,
        &format!("<model name='m'><link name='l'>{outline}{heights}</link></model>"),
    );
}

/// A world of Stage that includes another one and itself.
pub(super) fn included_stage(folder: &Path) {
    write(
        folder,
        "w.world",
        "include \"v.world\"\ninclude \"w.world\"\nposition()\n",
    );
    write(
        folder,
        "v.world",
        "include \"w.world\"\ninclude \"/dev/zero\"\n".repeat(3000),
    );
}

/// A list of cylinders, packed.
pub(super) fn cylinders(folder: &Path) {
    add_packed(folder, "w.txt", &b"7 1,1 2,2\n".repeat(100_000), 1000);
}

/// A log of CARMEN that unpacks to gigabytes, and an application that plays it.
pub(super) fn packed_log(folder: &Path) {
    let line = b"FLASER 3 1 2 3 0 0 0 0 0 0 1 host 1\n";
    add_packed(folder, "a.log", &line.repeat(30_000), 1600);
    logged(folder);
}

/// A log of this text, and an application that plays it.
pub(super) fn log(folder: &Path, text: &str) {
    write(folder, "a.log", text);
    logged(folder);
}

fn logged(folder: &Path) {
    app(
        folder,
        "roots = [\"a\"]\n[schemas.a]\ntype = \"carmen/log\"\npath = \"a.log\"\n",
    );
}

/// A calibration of this text, and an application that reads it.
pub(super) fn calibration(folder: &Path, text: &str) {
    write(folder, "c.yaml", text);
    app(
        folder,
        "roots = [\"a\"]\n[schemas.a]\ntype = \"camera/files\"\npath = \"p\"\ncalibration = \"c.yaml\"\n",
    );
}

/// A world or a robot with fifty thousand unknown keys, each behind a head.
pub(super) fn keys(head: &str) -> String {
    lines(50_000, |n| format!("{head}key{n} = 1"))
}

/// A robot of this text, and an application with it.
pub(super) fn robot(folder: &Path, text: &str) {
    write(folder, "r.toml", text);
    write(folder, "w.toml", "");
    app(
        folder,
        "roots = [\"a\"]\n[schemas.a]\ntype = \"sim/robot\"\nworld = \"w.toml\"\nmodel = \"r.toml\"\n",
    );
}

/// A value that stands for ten times the one before.
pub(super) fn alias(number: usize) -> String {
    match number {
        0 => "a0: &a0 [1]".to_owned(),
        number => format!(
            "a{number}: &a{number} [{}]",
            vec![format!("*a{}", number - 1); 10].join(", ")
        ),
    }
}

/// A calibration whose matrix has so many numbers.
pub(super) fn matrix(numbers: usize) -> String {
    let numbers = "1, ".repeat(numbers);
    format!("image_width: 9\nimage_height: 9\ncamera_matrix: {{ data: [{numbers}] }}\n")
}
