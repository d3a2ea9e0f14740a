//! The interfaces of ROS 2 that every node has, and some more, with the definitions of Iron to Kilted.

use std::sync::LazyLock;

use super::Interfaces;

/// Messages in the order in which they contain each other, then services.
const MESSAGES: &[(&str, &str)] = &[
    ("builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/msg/Duration", "int32 sec\nuint32 nanosec"),
    (
        "std_msgs/msg/Header",
        "builtin_interfaces/Time stamp\nstring frame_id",
    ),
    (
        "service_msgs/msg/ServiceEventInfo",
        "uint8 event_type\nbuiltin_interfaces/Time stamp\nchar[16] client_gid\nint64 sequence_number",
    ),
    (
        "rcl_interfaces/msg/ParameterValue",
        "uint8 type\nbool bool_value\nint64 integer_value\nfloat64 double_value\nstring string_value\n\
         byte[] byte_array_value\nbool[] bool_array_value\nint64[] integer_array_value\n\
         float64[] double_array_value\nstring[] string_array_value",
    ),
    (
        "rcl_interfaces/msg/Parameter",
        "string name\nParameterValue value",
    ),
    (
        "rcl_interfaces/msg/FloatingPointRange",
        "float64 from_value\nfloat64 to_value\nfloat64 step",
    ),
    (
        "rcl_interfaces/msg/IntegerRange",
        "int64 from_value\nint64 to_value\nuint64 step",
    ),
    (
        "rcl_interfaces/msg/ParameterDescriptor",
        "string name\nuint8 type\nstring description\nstring additional_constraints\nbool read_only\n\
         bool dynamic_typing\nFloatingPointRange[<=1] floating_point_range\nIntegerRange[<=1] integer_range",
    ),
    (
        "rcl_interfaces/msg/ListParametersResult",
        "string[] names\nstring[] prefixes",
    ),
    (
        "rcl_interfaces/msg/SetParametersResult",
        "bool successful\nstring reason",
    ),
    (
        "rcl_interfaces/msg/ParameterEvent",
        "builtin_interfaces/Time stamp\nstring node\nParameter[] new_parameters\n\
         Parameter[] changed_parameters\nParameter[] deleted_parameters",
    ),
    (
        "rcl_interfaces/msg/Log",
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\n\
         uint32 line",
    ),
    ("lifecycle_msgs/msg/State", "uint8 id\nstring label"),
    ("lifecycle_msgs/msg/Transition", "uint8 id\nstring label"),
    (
        "lifecycle_msgs/msg/TransitionDescription",
        "Transition transition\nState start_state\nState goal_state",
    ),
    (
        "lifecycle_msgs/msg/TransitionEvent",
        "uint64 timestamp\nTransition transition\nState start_state\nState goal_state",
    ),
    (
        "bond/msg/Status",
        "std_msgs/Header header\nstring id\nstring instance_id\nbool active\nfloat32 heartbeat_timeout\n\
         float32 heartbeat_period",
    ),
    ("diagnostic_msgs/msg/KeyValue", "string key\nstring value"),
    (
        "diagnostic_msgs/msg/DiagnosticStatus",
        "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values",
    ),
    (
        "diagnostic_msgs/msg/DiagnosticArray",
        "std_msgs/Header header\nDiagnosticStatus[] status",
    ),
    (
        "type_description_interfaces/msg/FieldType",
        "uint8 type_id\nuint64 capacity\nuint64 string_capacity\nstring<=255 nested_type_name",
    ),
    (
        "type_description_interfaces/msg/Field",
        "string name\nFieldType type\nstring default_value",
    ),
    (
        "type_description_interfaces/msg/IndividualTypeDescription",
        "string<=255 type_name\nField[] fields",
    ),
    (
        "type_description_interfaces/msg/TypeDescription",
        "IndividualTypeDescription type_description\nIndividualTypeDescription[] referenced_type_descriptions",
    ),
    (
        "type_description_interfaces/msg/TypeSource",
        "string type_name\nstring encoding\nstring raw_file_contents",
    ),
    (
        "type_description_interfaces/msg/KeyValue",
        "string key\nstring value",
    ),
    ("unique_identifier_msgs/msg/UUID", "uint8[16] uuid"),
    (
        "action_msgs/msg/GoalInfo",
        "unique_identifier_msgs/UUID goal_id\nbuiltin_interfaces/Time stamp",
    ),
    ("action_msgs/msg/GoalStatus", "GoalInfo goal_info\nint8 status"),
    ("action_msgs/msg/GoalStatusArray", "GoalStatus[] status_list"),
    ("geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat64 z"),
    (
        "geometry_msgs/msg/Quaternion",
        "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    ),
    ("geometry_msgs/msg/Pose", "Point position\nQuaternion orientation"),
    (
        "geometry_msgs/msg/PoseStamped",
        "std_msgs/Header header\nPose pose",
    ),
];

const SERVICES: &[(&str, &str)] = &[
    (
        "rcl_interfaces/srv/ListParameters",
        "string[] prefixes\nuint64 depth\n---\nListParametersResult result",
    ),
    (
        "rcl_interfaces/srv/GetParameters",
        "string[] names\n---\nParameterValue[] values",
    ),
    (
        "rcl_interfaces/srv/GetParameterTypes",
        "string[] names\n---\nuint8[] types",
    ),
    (
        "rcl_interfaces/srv/DescribeParameters",
        "string[] names\n---\nParameterDescriptor[] descriptors",
    ),
    (
        "rcl_interfaces/srv/SetParameters",
        "Parameter[] parameters\n---\nSetParametersResult[] results",
    ),
    (
        "rcl_interfaces/srv/SetParametersAtomically",
        "Parameter[] parameters\n---\nSetParametersResult result",
    ),
    (
        "lifecycle_msgs/srv/ChangeState",
        "Transition transition\n---\nbool success",
    ),
    ("lifecycle_msgs/srv/GetState", "---\nState current_state"),
    (
        "lifecycle_msgs/srv/GetAvailableStates",
        "---\nState[] available_states",
    ),
    (
        "lifecycle_msgs/srv/GetAvailableTransitions",
        "---\nTransitionDescription[] available_transitions",
    ),
    (
        "action_msgs/srv/CancelGoal",
        "GoalInfo goal_info\n---\nint8 return_code\nGoalInfo[] goals_canceling",
    ),
    (
        "type_description_interfaces/srv/GetTypeDescription",
        "string type_name\nstring type_hash\nbool include_type_sources\n---\nbool successful\n\
         string failure_reason\nTypeDescription type_description\nTypeSource[] type_sources\n\
         KeyValue[] extra_information",
    ),
    ("std_srvs/srv/Empty", "---"),
    ("std_srvs/srv/Trigger", "---\nbool success\nstring message"),
    (
        "std_srvs/srv/SetBool",
        "bool data\n---\nbool success\nstring message",
    ),
];

/// The action of Nav2.
const NAVIGATE: &str = "nav2_msgs/action/NavigateToPose";

/// Its definition, of which the distributions have different results.
fn navigate(result: &str) -> String {
    format!(
        "geometry_msgs/PoseStamped pose\nstring behavior_tree\n---\n{result}\n---\n\
         geometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n\
         builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\nfloat32 distance_remaining"
    )
}

/// The interfaces of time, services, parameters, life cycles, logs, diagnostics, actions, of `std_srvs`,
/// and the action of Nav2.
pub fn standard() -> &'static Interfaces {
    static STANDARD: LazyLock<Interfaces> = LazyLock::new(|| {
        let mut interfaces = Interfaces::default();
        let messages = MESSAGES
            .iter()
            .try_for_each(|(name, definition)| interfaces.message(name, definition));
        let services = SERVICES
            .iter()
            .try_for_each(|(name, definition)| interfaces.service(name, definition));
        let result = "uint16 error_code\nstring error_msg";
        let actions = interfaces.action(NAVIGATE, &navigate(result));
        messages
            .and(services)
            .and(actions)
            .expect("the definitions above are valid");
        interfaces
    });
    &STANDARD
}

/// The same with the forms of Humble: the result of `NavigateToPose` is empty.
pub fn humble() -> &'static Interfaces {
    static HUMBLE: LazyLock<Interfaces> = LazyLock::new(|| {
        let mut interfaces = standard().clone();
        interfaces
            .message("std_msgs/msg/Empty", "")
            .and(interfaces.action(NAVIGATE, &navigate("std_msgs/Empty result")))
            .expect("the definitions above are valid");
        interfaces
    });
    &HUMBLE
}
