//! Tests of what is written to a file, and of what is refused.

use std::os::unix::fs::PermissionsExt;

use jde_types::{Pose2D, Value as _};

use super::*;

fn tuning(name: &str, unit: &str, before: f64, now: f64) -> Tuning {
    Tuning {
        schema: "goon".to_owned(),
        name: name.to_owned(),
        former_name: None,
        value_type: f64::describe(),
        unit: unit.to_owned(),
        choices: Vec::new(),
        before: Some(Value::Float(before)),
        now: Value::Float(now),
        is_back: false,
    }
}

/// Saves into a file with this text. Returns the text afterwards, or the faults.
fn saved(text: &str, tunings: &[Tuning]) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    fs::write(&file, text).unwrap();
    let result = save(&file, tunings).map_err(|faults| faults.to_string());
    let after = fs::read_to_string(&file).unwrap();
    if result.is_err() {
        assert_eq!(after, text, "nothing is written");
    }
    result.map(|_| after)
}

#[test]
fn values_take_their_places_in_their_units_and_comments_stay() {
    let text = "# A robot.\n[schemas.goon]  # drives\ntype = \"goon\"\nfast = \"30 cm/s\"  # was 20\n\
                turn=\"45deg\"\nslow = 0.1\nperiod = \"10 Hz\"\n\n[schemas.stop]\ntype = \"stop\"\n";
    let tunings = [
        tuning("turn", "rad", 45_f64.to_radians(), 30_f64.to_radians()),
        tuning("fast", "m/s", 0.3, 0.45),
        tuning("slow", "m/s", 0.1, f64::from(0.2_f32)),
        tuning("period", "s", 0.1, 0.05),
        tuning("ahead", "m", 1.0, 2.0),
    ];
    let expected = "# A robot.\n[schemas.goon]  # drives\ntype = \"goon\"\nahead = 2.0\nfast = \"45 cm/s\"  # was 20\n\
                    turn=\"30deg\"\nslow = 0.2\nperiod = 0.05\n\n[schemas.stop]\ntype = \"stop\"\n";
    assert_eq!(saved(text, &tunings).unwrap(), expected);
}

#[test]
fn every_form_of_a_schema_stays_as_it_is() {
    let fast = [tuning("fast", "m/s", 0.3, 0.5)];
    for (text, expected) in [
        (
            "schemas.goon = { type = \"goon\", fast = 0.3 }",
            "schemas.goon = { type = \"goon\", fast = 0.5 }",
        ),
        (
            "schemas.goon = { type = \"goon\" }",
            "schemas.goon = { type = \"goon\", fast = 0.5 }",
        ),
        (
            "[schemas]\ngoon.type = \"goon\"",
            "[schemas]\ngoon.type = \"goon\"\ngoon.fast = 0.5",
        ),
        (
            "[schemas.goon]\ntype = \"goon\" # it\n",
            "[schemas.goon]\ntype = \"goon\" # it\nfast = 0.5\n",
        ),
    ] {
        assert_eq!(saved(text, &fast).unwrap(), expected);
    }
}

#[test]
fn structures_and_choices_are_written_as_they_are_there() {
    let pose = |x: f64| {
        let fields = [("x", x), ("y", 2.0), ("theta", 0.0)];
        Value::Map(
            fields
                .map(|(name, number)| (name.to_owned(), Value::Float(number)))
                .to_vec(),
        )
    };
    let start = Tuning {
        value_type: Pose2D::describe(),
        before: Some(pose(1.0)),
        now: pose(1.5),
        ..tuning("start", "", 0.0, 0.0)
    };
    let mode = Tuning {
        choices: vec!["wall".to_owned(), "follow".to_owned()],
        before: Some(Value::UInt(0)),
        now: Value::UInt(1),
        ..tuning("mode", "", 0.0, 0.0)
    };
    for (old, new) in [
        ("start = [1.0, 2.0, 0.0]", "start = [1.5, 2.0, 0.0]"),
        (
            "start = { x = 1.0, y = 2.0, theta = 0.0 }",
            "start = { x = 1.5, y = 2.0, theta = 0.0 }",
        ),
        (
            "start.x = 1.0 # east\nstart.y = 2\nstart.theta = 0",
            "start.x = 1.5 # east\nstart.y = 2.0\nstart.theta = 0.0",
        ),
    ] {
        let file =
            |start: &str, mode: &str| format!("[schemas.goon]\ntype = \"goon\"\nmode = '{mode}'\n{start}\n");
        let after = saved(&file(old, "wall"), &[start.clone(), mode.clone()]).unwrap();
        assert_eq!(after.replace('"', "'"), file(new, "follow").replace('"', "'"));
    }
}

#[test]
fn a_value_with_one_field_is_written_where_the_field_is_named() {
    let fast = [tuning("fast", "m/s", 0.3, 0.5)];
    let field = f64::describe().fields[0].name.clone();
    for old in [
        format!("[schemas.goon]\ntype = \"goon\"\nfast.{field} = 0.3 # it\n"),
        format!("[schemas.goon]\ntype = \"goon\"\nfast = {{ {field} = 0.3 }}\n"),
        format!("[schemas.goon]\ntype = \"goon\"\n\n[schemas.goon.fast]\n{field} = 0.3\n"),
    ] {
        assert_eq!(saved(&old, &fast).unwrap(), old.replace("0.3", "0.5"));
    }
}

#[test]
fn a_byte_order_mark_and_the_endings_of_lines_stay() {
    let fast = [tuning("fast", "m/s", 0.3, 0.5)];
    for (text, expected) in [
        (
            "\u{feff}[schemas.goon]\r\ntype = \"goon\"\r\nfast = 0.3\r\n",
            "\u{feff}[schemas.goon]\r\ntype = \"goon\"\r\nfast = 0.5\r\n",
        ),
        (
            "[schemas.goon]\r\ntype = \"goon\"\r\nslow = 1\r\n",
            "[schemas.goon]\r\ntype = \"goon\"\r\nfast = 0.5\r\nslow = 1\r\n",
        ),
        (
            "[schemas.goon]\r\ntype = \"goon\"",
            "[schemas.goon]\r\ntype = \"goon\"\r\nfast = 0.5",
        ),
    ] {
        assert_eq!(saved(text, &fast).unwrap(), expected);
    }
}

#[test]
fn a_file_whose_form_does_not_permit_the_edit_stays() {
    let error = saved(
        "schemas = { goon.type = \"goon\" }\n",
        &[tuning("fast", "m/s", 0.3, 0.5)],
    )
    .unwrap_err();
    for part in ["its form does not permit this edit", "goon.fast = 0.5"] {
        assert!(error.contains(part), "{part} in {error}");
    }
}

#[test]
fn a_float_of_32_bits_is_the_same_as_in_the_file() {
    let text = "[schemas.goon]\ntype = \"goon\"\nfast = 0.3\n";
    let fast = tuning("fast", "m/s", f64::from(0.3_f32), f64::from(0.4_f32));
    assert!(saved(text, &[fast]).unwrap().ends_with("\nfast = 0.4\n"));
}

#[test]
fn whole_numbers_are_compared_and_written_exactly() {
    let count = |before: Value, now: Value| Tuning {
        value_type: u64::describe(),
        before: Some(before),
        now,
        ..tuning("count", "", 0.0, 0.0)
    };
    let text = "[schemas.goon]\ntype = \"goon\"\ncount = 4000000000\n";
    let one_more = count(Value::Int(4_000_000_000), Value::UInt(4_000_000_001));
    assert!(
        saved(text, &[one_more])
            .unwrap()
            .ends_with("\ncount = 4000000001\n")
    );
    let large = count(Value::Int(4_000_000_000), Value::UInt(9_007_199_254_740_993));
    assert!(
        saved(text, &[large])
            .unwrap()
            .ends_with("\ncount = 9007199254740993\n")
    );
    let other = count(Value::Int(4_000_000_002), Value::UInt(1));
    assert!(saved(text, &[other]).unwrap_err().contains("was changed here"));
    // The name of no choice is not the first one.
    let mode = Tuning {
        choices: vec!["wall".to_owned(), "follow".to_owned()],
        before: Some(Value::UInt(0)),
        now: Value::UInt(1),
        ..tuning("mode", "", 0.0, 0.0)
    };
    let text = "[schemas.goon]\ntype = \"goon\"\nmode = \"walls\"\n";
    assert!(saved(text, &[mode]).unwrap_err().contains("was changed here"));
}

#[test]
fn what_somebody_changed_meanwhile_is_not_overwritten() {
    let text = "[schemas.goon]\ntype = \"goon\"\nfast = 0.7\n";
    let error = saved(text, &[tuning("fast", "m/s", 0.3, 0.5)]).unwrap_err();
    for part in [
        "robot.toml:3",
        "was changed here since the run began",
        "fast = 0.5",
    ] {
        assert!(error.contains(part), "{part} in {error}");
    }
    let overwritten = Tuning {
        before: None,
        ..tuning("fast", "m/s", 0.3, 0.5)
    };
    assert!(saved(text, &[overwritten]).unwrap().ends_with("fast = 0.5\n"));
    // A file that states the value already has nothing to overwrite.
    assert_eq!(saved(text, &[tuning("fast", "m/s", 0.3, 0.7)]).unwrap(), text);
    let error = saved(
        "[schemas.gone]\ntype = \"goon\"\n",
        &[tuning("fast", "m/s", 0.3, 0.5)],
    )
    .unwrap_err();
    assert!(error.contains("it has no schema `goon`"), "{error}");
    let error = saved("[schemas.goon\n", &[tuning("fast", "m/s", 0.3, 0.5)]).unwrap_err();
    assert!(error.contains("this is not TOML"), "{error}");
}

#[test]
fn a_value_of_the_start_is_compared_with_the_file_of_now() {
    let back = Tuning {
        is_back: true,
        ..tuning("fast", "m/s", 0.4, 0.4)
    };
    for same in ["", "fast = 0.4\n"] {
        let text = format!("[schemas.goon]\ntype = \"goon\"\n{same}");
        assert_eq!(saved(&text, std::slice::from_ref(&back)).unwrap(), text);
    }
    let text = "[schemas.goon]\ntype = \"goon\"\nfast = 0.3\n";
    let error = saved(text, std::slice::from_ref(&back)).unwrap_err();
    assert!(error.contains("was changed here since the run began"), "{error}");
    let overwritten = Tuning { before: None, ..back };
    assert!(saved(text, &[overwritten]).unwrap().ends_with("fast = 0.4\n"));
}

#[test]
fn a_read_only_file_is_refused_with_what_permits_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    fs::write(&file, "[schemas.goon]\ntype = \"goon\"\n").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).unwrap();
    let error = save(&file, &[tuning("fast", "m/s", 0.3, 0.5)])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("it is read-only") && error.contains("chmod u+w"),
        "{error}"
    );
}
