//! The hash by which ROS 2 distinguishes types (REP-2016, RIHS01). It is the hash of the type as defined in
//! ROS 2. A shared value has a fixed size, so its sequences and texts have bounds; in ROS 2 they have none unless the
//! field says so. On the wire the bytes are the same.

use std::collections::BTreeMap;

use hiroz_schema::{
    FieldDescription, FieldTypeDescription, TypeDescription, TypeDescriptionMsg, TypeId, calculate_hash,
};
use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use jde_ros::definition::{name, texts};

/// Offsets from the number of a kind to that of an array and of an unbounded sequence of it.
const ARRAY_OFFSET: u8 = TypeId::NESTED_TYPE_ARRAY - TypeId::NESTED_TYPE;
const SEQUENCE_OFFSET: u8 = TypeId::NESTED_TYPE_UNBOUNDED_SEQUENCE - TypeId::NESTED_TYPE;
const BOUNDED_SEQUENCE: u8 = TypeId::BOUNDED_SEQUENCE_OFFSET;

/// Returns the hash of a type, as in `RIHS01_9c45bf16...`. It equals that of the ROS 2 type of the same name
/// if the type has the same fields.
#[must_use]
pub fn rihs01(value_type: &Type) -> String {
    let mut parts = BTreeMap::new();
    referenced(value_type, &mut parts);
    let message = TypeDescriptionMsg {
        type_description: describe_type(value_type),
        referenced_type_descriptions: parts.into_values().collect(),
    };
    calculate_hash(&message).to_rihs_string()
}

/// Collects the types that a type contains, by name, each once.
pub(crate) fn referenced(value_type: &Type, parts: &mut BTreeMap<String, TypeDescription>) {
    for field in &value_type.fields {
        if let FieldKind::Struct(inner) = &field.kind
            && texts(field).is_none()
            && parts.insert(name(inner), describe_type(inner)).is_none()
        {
            referenced(inner, parts);
        }
    }
}

/// The description of a type alone.
pub(crate) fn describe_type(value_type: &Type) -> TypeDescription {
    let mut fields: Vec<_> = value_type.fields.iter().map(describe_field).collect();
    if fields.is_empty() {
        fields.push(placeholder());
    }
    TypeDescription {
        type_name: name(value_type),
        fields,
    }
}

/// The field that a structure without fields has in ROS 2.
pub(crate) fn placeholder() -> FieldDescription {
    FieldDescription {
        name: "structure_needs_at_least_one_member".to_owned(),
        field_type: FieldTypeDescription::primitive(TypeId::UINT8),
        default_value: String::new(),
    }
}

fn describe_field(field: &Field) -> FieldDescription {
    let is_bounded = field.notation.is_bounded;
    let mut nested_type_name = String::new();
    let mut bound_of_texts = None;
    let kind = match &field.kind {
        FieldKind::Scalar(Scalar::U8) if field.notation.is_byte => TypeId::BYTE,
        FieldKind::Scalar(scalar) => number(*scalar),
        FieldKind::Struct(inner) => match texts(field) {
            Some(capacity) => {
                let bounded = inner.fields.iter().any(|text| text.notation.is_bounded);
                bound_of_texts = bounded.then_some(capacity);
                text_id(bounded)
            }
            None => {
                nested_type_name = name(inner);
                TypeId::NESTED_TYPE
            }
        },
    };
    let (type_id, capacity) = match field.form {
        Form::One => (kind, 0),
        Form::Array(count) => (kind + ARRAY_OFFSET, count),
        Form::Sequence { capacity, .. } if is_bounded => (kind + BOUNDED_SEQUENCE, capacity),
        Form::Sequence { .. } => (kind + SEQUENCE_OFFSET, 0),
        Form::Text { capacity, .. } => {
            bound_of_texts = is_bounded.then_some(capacity);
            (text_id(is_bounded), 0)
        }
    };
    FieldDescription {
        name: field.name.clone(),
        field_type: FieldTypeDescription {
            type_id,
            capacity: capacity as u64,
            string_capacity: bound_of_texts.unwrap_or_default() as u64,
            nested_type_name,
        },
        default_value: String::new(),
    }
}

/// The identifier of a text with a bound, or without one.
fn text_id(is_bounded: bool) -> u8 {
    match is_bounded {
        true => TypeId::BOUNDED_STRING,
        false => TypeId::STRING,
    }
}

/// The identifier of a number's type.
pub(crate) fn number(scalar: Scalar) -> u8 {
    match scalar {
        Scalar::Bool => TypeId::BOOL,
        Scalar::U8 => TypeId::UINT8,
        Scalar::U16 => TypeId::UINT16,
        Scalar::U32 => TypeId::UINT32,
        Scalar::U64 => TypeId::UINT64,
        Scalar::I8 => TypeId::INT8,
        Scalar::I16 => TypeId::INT16,
        Scalar::I32 => TypeId::INT32,
        Scalar::I64 => TypeId::INT64,
        Scalar::F32 => TypeId::FLOAT32,
        Scalar::F64 => TypeId::FLOAT64,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The hashes of ROS 2 Jazzy, as `rosbags` 0.11.9 computes them from its own definitions.
    const JAZZY: &[(&str, &str)] = &[
        (
            "std_msgs/msg/Bool",
            "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
        ),
        (
            "std_msgs/msg/UInt8",
            "6138bd83d8c3569cb80a667db03cfc1629f529fee79d944c39c34e352e72f010",
        ),
        (
            "std_msgs/msg/UInt16",
            "08a406e4b022bc22e907f985d6a9e9dd1d4fbecae573549cf49350113e7757b1",
        ),
        (
            "std_msgs/msg/UInt32",
            "a5c874829b752bc5fa190024b0ad76f578cc278271e855c7d02a818b3516fb4a",
        ),
        (
            "std_msgs/msg/UInt64",
            "fbdc52018fc13755dce18024d1a671c856aa8b4aaf63adfb095b608f98e8c943",
        ),
        (
            "std_msgs/msg/Int8",
            "26525065a403d972cb672f0777e333f0c799ad444ae5fcd79e43d1e73bd0f440",
        ),
        (
            "std_msgs/msg/Int16",
            "1dcc3464e47c288a55f943a389d337cdb06804de3f5cd7a266b0de718eee17e5",
        ),
        (
            "std_msgs/msg/Int32",
            "b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb",
        ),
        (
            "std_msgs/msg/Int64",
            "8cd1048c2f186b6bd9a92472dc1ce51723c0833a221e2b7aecfff111774f4b49",
        ),
        (
            "std_msgs/msg/Float32",
            "7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2",
        ),
        (
            "std_msgs/msg/Float64",
            "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
        ),
        (
            "builtin_interfaces/msg/Time",
            "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
        ),
        (
            "std_msgs/msg/Header",
            "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
        ),
        (
            "geometry_msgs/msg/Point",
            "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881",
        ),
        (
            "geometry_msgs/msg/Vector3",
            "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d",
        ),
        (
            "geometry_msgs/msg/Quaternion",
            "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684",
        ),
        (
            "geometry_msgs/msg/Pose",
            "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa",
        ),
        (
            "geometry_msgs/msg/PoseStamped",
            "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
        ),
        (
            "geometry_msgs/msg/PoseWithCovariance",
            "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb",
        ),
        (
            "geometry_msgs/msg/Pose2D",
            "d68efa5b46e70f7b16ca23085474fdac5a44b638783ec42f661da64da4724ccc",
        ),
        (
            "geometry_msgs/msg/Transform",
            "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc",
        ),
        (
            "geometry_msgs/msg/TransformStamped",
            "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
        ),
        (
            "geometry_msgs/msg/Twist",
            "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
        ),
        (
            "geometry_msgs/msg/TwistWithCovariance",
            "49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18",
        ),
        (
            "nav_msgs/msg/Odometry",
            "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
        ),
        (
            "nav_msgs/msg/MapMetaData",
            "2772d4b2000ef2b35dbaeb80fd3946c1369f817fb4f75677d916d27c17d763c8",
        ),
        (
            "nav_msgs/msg/OccupancyGrid",
            "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
        ),
        (
            "nav_msgs/msg/Path",
            "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b",
        ),
        (
            "sensor_msgs/msg/LaserScan",
            "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
        ),
        (
            "sensor_msgs/msg/Range",
            "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
        ),
        (
            "sensor_msgs/msg/Image",
            "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
        ),
        (
            "sensor_msgs/msg/BatteryState",
            "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741",
        ),
        (
            "sensor_msgs/msg/Imu",
            "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
        ),
        (
            "sensor_msgs/msg/JointState",
            "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
        ),
        (
            "sensor_msgs/msg/NavSatStatus",
            "d1ed3befa628e09571bd273b888ba1c1fd187c9a5e0006b385d7e5e9095a3204",
        ),
        (
            "sensor_msgs/msg/NavSatFix",
            "62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404",
        ),
        (
            "sensor_msgs/msg/CompressedImage",
            "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
        ),
        (
            "sensor_msgs/msg/RegionOfInterest",
            "ad16bcba5f9131dcdba6fbded19f726f5440e3c513b4fb586dd3027eeed8abb1",
        ),
        (
            "sensor_msgs/msg/CameraInfo",
            "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
        ),
        (
            "sensor_msgs/msg/PointField",
            "5c6a4750728c2bcfbbf7037225b20b02d4429634732146b742dee1726637ef01",
        ),
        (
            "sensor_msgs/msg/PointCloud2",
            "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
        ),
    ];

    #[test]
    fn standard_types_have_the_hashes_of_ros() {
        let hashes: BTreeMap<String, String> = jde_types::standard()
            .iter()
            .map(|value_type| (name(value_type), rihs01(value_type)))
            .collect();
        for (name, hash) in JAZZY {
            assert_eq!(hashes[*name], format!("RIHS01_{hash}"), "{name}");
        }
        let is_ros = |name: &&String| !name.starts_with("jde_msgs/") && !name.contains("/srv/");
        let ros_count = hashes.keys().filter(is_ros).count();
        assert_eq!(ros_count, JAZZY.len(), "each type with a ROS name is compared");
    }

    /// Interfaces with bounds and bytes, and their hashes in ROS 2 Jazzy.
    const BOUNDED: &[(&str, &str, &str)] = &[
        (
            "type_description_interfaces/msg/FieldType",
            "uint8 type_id 0\nuint64 capacity\nuint64 string_capacity\nstring<=255 nested_type_name\n",
            "a70b6dd919645a03a3586f7f821defbc886ea3e531a1d95cc0f380a3973ccaa6",
        ),
        (
            "rcl_interfaces/msg/ParameterDescriptor",
            "string name\nuint8 type\nstring description\nstring additional_constraints\nbool read_only false\n\
             bool dynamic_typing false\nFloatingPointRange[<=1] floating_point_range\nIntegerRange[<=1] integer_range\n\
             ===\nMSG: rcl_interfaces/FloatingPointRange\nfloat64 from_value\nfloat64 to_value\nfloat64 step\n\
             ===\nMSG: rcl_interfaces/IntegerRange\nint64 from_value\nint64 to_value\nuint64 step\n",
            "52175dbfda6c51153101d33d2a9da05743f66f02d5ab2ca9ec4709b46b73d704",
        ),
        (
            "diagnostic_msgs/msg/DiagnosticStatus",
            "byte OK=0\nbyte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values\n\
             ===\nMSG: diagnostic_msgs/KeyValue\nstring key\nstring value\n",
            "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4",
        ),
    ];

    #[test]
    fn bounds_and_bytes_of_an_interface_are_part_of_its_hash() {
        for (name, text, hash) in BOUNDED {
            let read = jde_ros::definition::read_interface(name, text, |_| 16, |_| None).unwrap();
            assert_eq!(rihs01(&read), format!("RIHS01_{hash}"), "{name}");
        }
        // The same lists in every form, as another reader of interfaces describes them.
        let name = "my_msgs/msg/Lists";
        let text = "bool[<=4] a\nstring<=8[] b\nstring<=8[<=3] c\nstring[<=3] d\nbyte[] e\nbyte[2] f\nstring<=8[2] g\n";
        let mut interfaces = crate::interface::Interfaces::default();
        interfaces.message(name, text).unwrap();
        let read = jde_ros::definition::read_interface(name, text, |_| 16, |_| None).unwrap();
        assert_eq!(Some(rihs01(&read)), interfaces.hash(name));
    }

    #[test]
    fn a_type_without_fields_has_the_hash_of_ros() {
        let empty = jde_ros::definition::read("std_msgs/msg/Empty", "").unwrap();
        assert_eq!(
            rihs01(&empty),
            "RIHS01_20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312"
        );
    }
}
