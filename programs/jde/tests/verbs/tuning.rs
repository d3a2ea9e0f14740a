//! `jde tuned`: what differs from the application's file, written to it or set back.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use serde_json::json;

use crate::attached::Sandbox;
use crate::support::root;

#[test]
fn tuned_values_are_listed_and_saved_to_the_file_and_set_back() {
    let sandbox = Sandbox::new();
    let text = fs::read_to_string(root().join("apps/safe-navigation.toml")).unwrap();
    let text = text.replace("\"../", &format!("\"{}/", root().display()));
    let file = sandbox.folder().join("robot.toml");
    fs::write(&file, &text).unwrap();
    let name = file.to_str().unwrap();
    let _running = sandbox.start(name, &[]);
    assert!(sandbox.run_ok(&["tuned"]).starts_with("no modulation differs"));
    sandbox.run_ok(&["set", "goon.fast", "0.3 m/s"]);
    sandbox.run_ok(&["set", "vff.period", "50ms"]);
    let listed = sandbox.json(&["tuned"]);
    let fast = json!({"variable": "goon.fast", "unit": "m/s", "file": 0.4, "now": 0.3});
    assert_eq!(listed.as_array().map(Vec::len), Some(2), "{listed}");
    assert_eq!(listed[0], fast);

    fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).unwrap();
    let refused = sandbox.run(&["tuned", "--save"]);
    assert_eq!(refused.status, Some(2));
    assert!(refused.err.contains("it is read-only"), "{}", refused.err);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let saved = sandbox.run_ok(&["tuned", "goon.*", "--save"]);
    assert!(saved.contains("goon.fast = 0.3"), "{saved}");
    let added = "\nfast = 0.3";
    assert_eq!(fs::read_to_string(&file).unwrap().replacen(added, "", 1), text);

    // The value in the file is not that of the start any more, even if that holds again.
    for fast in ["0.4 m/s", "0.35 m/s"] {
        sandbox.run_ok(&["set", "goon.fast", fast]);
        let refused = sandbox.run(&["tuned", "goon.*", "--save"]);
        assert_eq!(refused.status, Some(2));
        let reason = "was changed here since the run began";
        assert!(refused.err.contains(reason), "{}", refused.err);
    }
    sandbox.run_ok(&["tuned", "goon.*", "--save", "--overwrite"]);
    assert!(fs::read_to_string(&file).unwrap().contains("\nfast = 0.35"));
    sandbox.run_ok(&["tuned", "--back"]);
    assert!(sandbox.run_ok(&["tuned"]).starts_with("no modulation differs"));
}
