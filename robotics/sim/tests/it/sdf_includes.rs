//! Models that worlds in SDF include, and the limits of what they may be made of.

use std::path::Path;

use crate::sdf_worlds::{BOX, boxes, faults, import_with, report};

#[test]
fn models_are_found_beside_the_file_and_in_stated_folders() {
    let text = "<sdf version='1.9'><world name='w'>\n\
        <include><uri>model://sun</uri></include>\n\
        <include><uri>https://example.org/1.0/Open/models/Ground Plane</uri></include>\n\
        <include><uri>model://desk</uri><name>first</name><pose>2 0 0 0 0 0</pose></include>\n\
        <include><uri>model://desk</uri><pose>4 0 0 0 0 0</pose><placement_frame>foot</placement_frame></include>\n\
        <include><uri>chairs/chair.sdf</uri></include>\n\
        <include><uri>model://far</uri><pose>8 0 0 0 0 0</pose></include>\n\
        <include><uri>model://nowhere</uri></include>\n\
        <include><uri>https://example.org/1.0/Open/models/Shelf</uri></include>\n\
        </world></sdf>";
    let desk = "<sdf version='1.9'><model name='desk'><static>1</static><pose>7 7 0 0 0 0</pose>\
        <frame name='foot'><pose>1 0 0 0 0 0</pose></frame><link name='l'>BOX</link></model></sdf>";
    let room = "<sdf><model name='room'><static>1</static>\
        <include merge='true'><uri>model://desk</uri><pose>0 1 0 0 0 0</pose></include>\
        <link name='k'><pose relative_to='l'>0 2 0 0 0 0</pose>BOX</link>\
        <include><uri>model://room</uri></include></model></sdf>";
    let [desk, room] = [desk, room].map(|text| text.replace("BOX", BOX));
    let config = "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.9'>model.sdf</sdf>\
        <sdf version='9.0'>new.sdf</sdf></model>";
    let files = [
        ("worlds/world.sdf", text),
        ("models/desk/model.config", config),
        ("models/desk/model.sdf", &desk),
        ("worlds/chairs/chair.sdf", &desk),
        ("elsewhere/far/model.sdf", &room),
    ];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sdf/included");
    let models = [folder.join("elsewhere"), folder.join("models")];
    let imported = import_with("included", &files, &models).unwrap();
    assert_eq!(
        boxes(&imported),
        [[2000, 0], [3000, 0], [7000, 7000], [8000, 1000], [8000, 3000]]
    );
    let reasons = report(&imported);
    let searched = models.map(|folder| folder.display().to_string()).join(", ");
    let missing = format!(
        "it is neither in {searched} nor near it: name the folder that contains it with `--models DIR`"
    );
    let web =
        "it is on the Web: download it, and name the folder that contains its folder with `--models DIR`";
    for right in [
        format!("the model model://nowhere is left out: {missing} (line 8)"),
        format!("the model https://example.org/1.0/Open/models/Shelf is left out: {web} (line 9)"),
    ] {
        assert!(reasons.contains(&right), "{reasons:?}");
    }
}

#[test]
fn a_model_that_contains_itself_is_left_out_once() {
    let room = format!(
        "<sdf><model name='room'><link name='l'>{BOX}</link>\n<include><uri>room.sdf</uri></include></model></sdf>"
    );
    let files = [
        ("world.sdf", "<sdf><include><uri>room.sdf</uri></include></sdf>"),
        ("room.sdf", &room),
    ];
    let imported = import_with("own", &files, &[]).unwrap();
    assert_eq!(boxes(&imported), [[0, 0]]);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sdf/own/room.sdf");
    let own = format!(
        "the model room.sdf is left out: it contains itself ({}:2)",
        file.display()
    );
    assert_eq!(report(&imported)[1..], [own]);
}

#[test]
fn work_and_depth_are_limited() {
    let deep = faults("deep.sdf", &"<sdf>".repeat(20_000));
    assert_eq!(
        deep,
        ["1: its elements contain each other more than 500 levels deep"]
    );
    let nested = format!(
        "<sdf>{}{}</sdf>",
        "<model name='m'>".repeat(100),
        "</model>".repeat(100)
    );
    assert_eq!(
        faults("nested.sdf", &nested),
        ["1: its parts contain each other more than 64 levels deep"]
    );
    // Ten files, each of which includes the next one a hundred times.
    let file = |next: usize| {
        let includes = format!("<include><uri>{next}.sdf</uri></include>").repeat(100);
        (
            format!("{}.sdf", next - 1),
            format!("<sdf><model name='m'>{includes}</model></sdf>"),
        )
    };
    let texts: Vec<_> = (1..=10).map(file).collect();
    let mut files: Vec<_> = texts
        .iter()
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    files.push(("10.sdf", "<sdf><model name='m'/></sdf>"));
    let error = import_with("multiplied", &files, &[]).expect_err("it has 10^20 models");
    assert!(error.to_string().contains("needs more than"), "{error}");
}
