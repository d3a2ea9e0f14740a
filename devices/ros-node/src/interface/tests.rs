//! Hashes and values of interfaces, against those of ROS 2.

use std::sync::Arc;

use jde_ros::definition::{action_result, read_interface};
use jde_types::{Header, Value as _};
use proptest::prelude::*;
use serde_json::json;

use super::*;

/// Hashes of ROS 2 Jazzy, from the descriptions that `rosidl_generator_type_description` makes.
const JAZZY: &[(&str, &str)] = &[
    (
        "service_msgs/msg/ServiceEventInfo",
        "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
    ),
    (
        "rcl_interfaces/msg/ParameterEvent",
        "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
    ),
    (
        "rcl_interfaces/msg/Log",
        "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    ),
    (
        "lifecycle_msgs/msg/TransitionEvent",
        "d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38",
    ),
    (
        "bond/msg/Status",
        "87eaccffa254ffffadc0b61600452e8251740f06c25659a2dbda4927fdb1f70a",
    ),
    (
        "rcl_interfaces/srv/ListParameters",
        "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    ),
    (
        "rcl_interfaces/srv/GetParameters",
        "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    ),
    (
        "rcl_interfaces/srv/GetParameterTypes",
        "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
    ),
    (
        "rcl_interfaces/srv/DescribeParameters",
        "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    ),
    (
        "rcl_interfaces/srv/SetParameters",
        "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    ),
    (
        "rcl_interfaces/srv/SetParametersAtomically",
        "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
    ),
    (
        "lifecycle_msgs/srv/ChangeState",
        "356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5",
    ),
    (
        "lifecycle_msgs/srv/GetState",
        "800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795",
    ),
    (
        "lifecycle_msgs/srv/GetAvailableStates",
        "00a07d79d2207d71e81a8cbc1880e5d924cc16d4688ea8e8e06e443dc8f8aa1d",
    ),
    (
        "lifecycle_msgs/srv/GetAvailableTransitions",
        "59b7ecefce0982a8a844b9f2c4f14764c1c4543cc55e72924e2aa4adad83e9bc",
    ),
    (
        "type_description_interfaces/srv/GetTypeDescription",
        "69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5",
    ),
    (
        "std_srvs/srv/Empty",
        "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
    ),
    (
        "std_srvs/srv/Trigger",
        "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    ),
    (
        "std_srvs/srv/SetBool",
        "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    ),
    (
        "action_msgs/srv/CancelGoal",
        "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    ),
    (
        "action_msgs/msg/GoalStatusArray",
        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
    ),
];

#[test]
fn the_parts_of_an_action_have_the_hashes_of_ros() {
    let mut interfaces = standard().clone();
    for (name, definition) in [
        ("geometry_msgs/msg/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
        (
            "geometry_msgs/msg/Transform",
            "Vector3 translation\nQuaternion rotation",
        ),
        (
            "geometry_msgs/msg/TransformStamped",
            "std_msgs/Header header\nstring child_frame_id\nTransform transform",
        ),
        (
            "tf2_msgs/msg/TF2Error",
            "uint8 NO_ERROR=0\nuint8 error\nstring error_string",
        ),
    ] {
        interfaces.message(name, definition).unwrap();
    }
    interfaces
        .action(
            "tf2_msgs/action/LookupTransform",
            "string target_frame\nstring source_frame\nbuiltin_interfaces/Time source_time\n\
             builtin_interfaces/Duration timeout\nbuiltin_interfaces/Time target_time\nstring fixed_frame\n\
             bool advanced\n---\ngeometry_msgs/TransformStamped transform\ntf2_msgs/TF2Error error\n---\n",
        )
        .unwrap();
    for (part, hash) in [
        (
            "SendGoal",
            "4646ff5706c86b04d0a1098d329951a9731a7517e16702905de6073cc72c8530",
        ),
        (
            "GetResult",
            "3cd1715751899e3167b5aec3e4ac194f7da9e8493a77285f9f6a4c914f5e8b24",
        ),
        (
            "FeedbackMessage",
            "10cb89922dcb103e95c185d43e8a5efa3d38db996f733151a2f3e2ac133f4839",
        ),
    ] {
        let name = format!("tf2_msgs/action/LookupTransform_{part}");
        assert_eq!(interfaces.hash(&name), Some(format!("RIHS01_{hash}")), "{part}");
    }
}

#[test]
fn an_interface_is_described_with_what_it_contains() {
    let described = standard().description("std_srvs/srv/SetBool").unwrap();
    assert_eq!(
        described["type_description"]["fields"][0]["type"]["nested_type_name"],
        "std_srvs/srv/SetBool_Request"
    );
    let others = described["referenced_type_descriptions"].as_array().unwrap();
    let names: Vec<_> = others
        .iter()
        .map(|other| other["type_name"].as_str().unwrap())
        .collect();
    assert!(
        names.is_sorted() && names.contains(&"std_srvs/srv/SetBool_Event"),
        "{names:?}"
    );
    let name = "type_description_interfaces/msg/TypeDescription";
    assert!(standard().encode(name, &described).is_ok());
    let bounded = &standard().description(name).unwrap()["referenced_type_descriptions"][1]["fields"][3];
    let kind = json!({ "type_id": 21, "capacity": 0, "string_capacity": 255, "nested_type_name": "" });
    assert_eq!(bounded["type"], kind);
    assert_eq!(standard().description("std_srvs/srv/Other"), None);
}

#[test]
fn a_service_of_values_has_the_hash_of_its_definition() {
    let types = jde_types::standard();
    let of = |name: &str| types.iter().find(|value_type| value_type.name == name).unwrap();
    for service in [
        "std_srvs/srv/Empty",
        "std_srvs/srv/SetBool",
        "std_srvs/srv/Trigger",
    ] {
        let [request, response] = ["Request", "Response"].map(|part| of(&format!("{service}_{part}")));
        let hash = Interfaces::service_hash(service, request, response);
        assert_eq!(hash, standard().hash(service), "{service}");
        assert_eq!(
            Some(crate::hash::rihs01(response)),
            standard().hash(&response.name)
        );
        assert_eq!(
            Interfaces::service_hash("std_srvs/srv/Other", request, response),
            None
        );
    }
}

#[test]
fn an_action_of_values_has_the_hashes_of_its_definition() {
    let name = "demo/action/Go";
    let [goal, result, feedback] = [
        "int32 order\nstring why",
        "int32[] sequence",
        "std_msgs/Header header\nbyte near",
    ];
    let mut interfaces = standard().clone();
    let definition = format!("{goal}\n---\n{result}\n---\n{feedback}\n");
    interfaces.action(name, &definition).unwrap();
    let header = |name: &str| (name == "std_msgs/msg/Header").then(|| Arc::new(Header::describe()));
    let read =
        |part: &str, text: &str| read_interface(&format!("{name}_{part}"), text, |_| 9, header).unwrap();
    let response = format!("{}\n===\nMSG: demo/Go_Result\n{result}", action_result("demo/Go"));
    let goal = read("Goal", goal);
    let types = (read("GetResult_Response", &response), read("Feedback", feedback));
    let hashes = Interfaces::action_hashes(name, &goal, &types.0, &types.1).unwrap();
    let expected = ["SendGoal", "GetResult", "FeedbackMessage"];
    for (hash, part) in hashes.into_iter().zip(expected) {
        assert_eq!(Some(hash), interfaces.hash(&format!("{name}_{part}")), "{part}");
    }
    assert_eq!(
        Interfaces::action_hashes("demo/action/Come", &goal, &types.0, &types.1),
        None
    );
}

#[test]
fn interfaces_have_the_hashes_of_ros() {
    for (name, hash) in JAZZY {
        assert_eq!(standard().hash(name), Some(format!("RIHS01_{hash}")), "{name}");
    }
    assert_eq!(standard().hash("std_srvs/srv/Other"), None);
}

#[test]
fn a_value_is_a_message_in_the_layout_of_cdr() {
    let value = json!({ "sec": -2, "nanosec": 7 });
    let message = standard().encode("builtin_interfaces/msg/Time", &value).unwrap();
    assert_eq!(message, [0, 1, 0, 0, 0xfe, 0xff, 0xff, 0xff, 7, 0, 0, 0]);
    let empty = standard()
        .encode("std_srvs/srv/Trigger_Request", &json!({}))
        .unwrap();
    assert_eq!(empty, [0, 1, 0, 0, 0]);
    // In Humble the result is an empty message, which has one byte as any.
    let result = "nav2_msgs/action/NavigateToPose_GetResult_Response";
    let ended = humble().encode(result, &json!({ "status": 4 })).unwrap();
    assert_eq!(ended, [0, 1, 0, 0, 4, 0]);
    let text = standard()
        .encode(
            "std_srvs/srv/Trigger_Response",
            &json!({ "success": true, "message": "é" }),
        )
        .unwrap();
    assert_eq!(text, [0, 1, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0xc3, 0xa9, 0]);
}

#[test]
fn a_value_of_every_kind_survives() {
    let parameter = json!({ "name": "goon.fast", "value": {
        "type": 9, "bool_value": true, "integer_value": i64::MIN, "double_value": -0.5, "string_value": "a",
        "byte_array_value": [255], "bool_array_value": [], "integer_array_value": [1, -1],
        "double_array_value": [1e300], "string_array_value": ["", "b"] } });
    let event = json!({ "stamp": { "sec": 1, "nanosec": 2 }, "node": "/x", "new_parameters": [],
        "changed_parameters": [parameter.clone(), parameter], "deleted_parameters": [] });
    let message = standard()
        .encode("rcl_interfaces/msg/ParameterEvent", &event)
        .unwrap();
    assert_eq!(
        standard().decode("rcl_interfaces/msg/ParameterEvent", &message),
        Ok(event)
    );
}

#[test]
fn a_number_that_is_not_finite_does_not_become_0() {
    let name = "geometry_msgs/msg/Point";
    let message = standard()
        .encode(name, &json!({ "x": f64::NAN, "y": 2.0 }))
        .unwrap();
    let found = standard().decode(name, &message).unwrap();
    assert_eq!(found, json!({ "x": null, "y": 2.0, "z": 0.0 }));
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let said = |name: &str, value| standard().encode(name, &value).unwrap_err().to_string();
    assert_eq!(
        said("builtin_interfaces/msg/Time", json!({ "sec": 1.5 })),
        "`sec`: 1.5 is no int32"
    );
    assert_eq!(
        said("builtin_interfaces/msg/Time", json!({ "sec": 3_000_000_000_u32 })),
        "`sec`: 3000000000 is no int32"
    );
    assert_eq!(
        said("lifecycle_msgs/msg/State", json!({ "name": "x" })),
        "`lifecycle_msgs/msg/State` has no field `name`"
    );
    let two = json!({ "integer_range": [{}, {}] });
    assert!(said("rcl_interfaces/msg/ParameterDescriptor", two).contains("list of this length"));
    let mut interfaces = Interfaces::default();
    let refused = |interfaces: &mut Interfaces, text| interfaces.message("a/msg/B", text).unwrap_err().reason;
    assert_eq!(
        refused(&mut interfaces, "Other x"),
        "this type is not defined before"
    );
    assert_eq!(refused(&mut interfaces, "float64"), "expected a type and a name");
    assert_eq!(refused(&mut interfaces, "float64[ x"), "a `]` is missing");
    assert!(
        interfaces
            .message("a/msg/B", "# none\nuint8 A=1\nuint8 B = 2\n")
            .is_ok()
    );
}

proptest! {
    #[test]
    fn arbitrary_bytes_cause_no_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        bytes.splice(..0, [0, 1, 0, 0]);
        for name in ["rcl_interfaces/srv/SetParameters_Request", "diagnostic_msgs/msg/DiagnosticArray"] {
            if let Ok(value) = standard().decode(name, &bytes) {
                prop_assert!(standard().encode(name, &value).is_ok());
            }
        }
    }
}
