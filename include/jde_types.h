/*
 * The standard types of sensors and actuators, with the fields of their ROS 2 interfaces: SI units, axes of REP-103.
 * Each has a structure, and a description `<structure>_type` for tables of ports.
 *
 * Texts are UTF-8 without a NUL. Elements beyond a length are ignored; a length beyond the capacity is invalid.
 *
 * Generated from plugin/types; `cargo xtask headers` renews it.
 */
#ifndef JDE_TYPES_H
#define JDE_TYPES_H

#include "jde.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A jde_field at the offset `element`, for the tables below. */
#define JDE_FIELD(name, element, length, kind, form, capacity, doc, unit, type) \
    {(uint32_t)sizeof(jde_field), kind, form, capacity, name, doc, unit, element, length, type, 0u, 0u}

/** std_msgs/msg/Bool: True or false by itself. */
typedef struct jde_bool {
    /** The value. */
    uint8_t data;
} jde_bool;

typedef char jde_bool_has_its_size[sizeof(jde_bool) == 1 ? 1 : -1];

static const jde_field jde_bool_fields[] = {
    JDE_FIELD("data", offsetof(jde_bool, data), 0u, JDE_BOOL, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_bool_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_bool_fields), "std_msgs/msg/Bool", "True or false by itself.",
    sizeof(jde_bool), 1u, jde_bool_fields};

/** std_msgs/msg/UInt8: A number by itself. */
typedef struct jde_uint8 {
    /** The value. */
    uint8_t data;
} jde_uint8;

typedef char jde_uint8_has_its_size[sizeof(jde_uint8) == 1 ? 1 : -1];

static const jde_field jde_uint8_fields[] = {
    JDE_FIELD("data", offsetof(jde_uint8, data), 0u, JDE_U8, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_uint8_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_uint8_fields), "std_msgs/msg/UInt8", "A number by itself.",
    sizeof(jde_uint8), 1u, jde_uint8_fields};

/** std_msgs/msg/UInt16: A number by itself. */
typedef struct jde_uint16 {
    /** The value. */
    uint16_t data;
} jde_uint16;

typedef char jde_uint16_has_its_size[sizeof(jde_uint16) == 2 ? 1 : -1];

static const jde_field jde_uint16_fields[] = {
    JDE_FIELD("data", offsetof(jde_uint16, data), 0u, JDE_U16, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_uint16_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_uint16_fields), "std_msgs/msg/UInt16", "A number by itself.",
    sizeof(jde_uint16), 2u, jde_uint16_fields};

/** std_msgs/msg/UInt32: A number by itself. */
typedef struct jde_uint32 {
    /** The value. */
    uint32_t data;
} jde_uint32;

typedef char jde_uint32_has_its_size[sizeof(jde_uint32) == 4 ? 1 : -1];

static const jde_field jde_uint32_fields[] = {
    JDE_FIELD("data", offsetof(jde_uint32, data), 0u, JDE_U32, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_uint32_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_uint32_fields), "std_msgs/msg/UInt32", "A number by itself.",
    sizeof(jde_uint32), 4u, jde_uint32_fields};

/** std_msgs/msg/UInt64: A number by itself. */
typedef struct jde_uint64 {
    /** The value. */
    uint64_t data;
} jde_uint64;

typedef char jde_uint64_has_its_size[sizeof(jde_uint64) == 8 ? 1 : -1];

static const jde_field jde_uint64_fields[] = {
    JDE_FIELD("data", offsetof(jde_uint64, data), 0u, JDE_U64, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_uint64_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_uint64_fields), "std_msgs/msg/UInt64", "A number by itself.",
    sizeof(jde_uint64), 8u, jde_uint64_fields};

/** std_msgs/msg/Int8: A number by itself. */
typedef struct jde_int8 {
    /** The value. */
    int8_t data;
} jde_int8;

typedef char jde_int8_has_its_size[sizeof(jde_int8) == 1 ? 1 : -1];

static const jde_field jde_int8_fields[] = {
    JDE_FIELD("data", offsetof(jde_int8, data), 0u, JDE_I8, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_int8_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_int8_fields), "std_msgs/msg/Int8", "A number by itself.",
    sizeof(jde_int8), 1u, jde_int8_fields};

/** std_msgs/msg/Int16: A number by itself. */
typedef struct jde_int16 {
    /** The value. */
    int16_t data;
} jde_int16;

typedef char jde_int16_has_its_size[sizeof(jde_int16) == 2 ? 1 : -1];

static const jde_field jde_int16_fields[] = {
    JDE_FIELD("data", offsetof(jde_int16, data), 0u, JDE_I16, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_int16_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_int16_fields), "std_msgs/msg/Int16", "A number by itself.",
    sizeof(jde_int16), 2u, jde_int16_fields};

/** std_msgs/msg/Int32: A number by itself. */
typedef struct jde_int32 {
    /** The value. */
    int32_t data;
} jde_int32;

typedef char jde_int32_has_its_size[sizeof(jde_int32) == 4 ? 1 : -1];

static const jde_field jde_int32_fields[] = {
    JDE_FIELD("data", offsetof(jde_int32, data), 0u, JDE_I32, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_int32_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_int32_fields), "std_msgs/msg/Int32", "A number by itself.",
    sizeof(jde_int32), 4u, jde_int32_fields};

/** std_msgs/msg/Int64: A number by itself. */
typedef struct jde_int64 {
    /** The value. */
    int64_t data;
} jde_int64;

typedef char jde_int64_has_its_size[sizeof(jde_int64) == 8 ? 1 : -1];

static const jde_field jde_int64_fields[] = {
    JDE_FIELD("data", offsetof(jde_int64, data), 0u, JDE_I64, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_int64_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_int64_fields), "std_msgs/msg/Int64", "A number by itself.",
    sizeof(jde_int64), 8u, jde_int64_fields};

/** std_msgs/msg/Float32: A number by itself. */
typedef struct jde_float32 {
    /** The value. */
    float data;
} jde_float32;

typedef char jde_float32_has_its_size[sizeof(jde_float32) == 4 ? 1 : -1];

static const jde_field jde_float32_fields[] = {
    JDE_FIELD("data", offsetof(jde_float32, data), 0u, JDE_F32, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_float32_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_float32_fields), "std_msgs/msg/Float32", "A number by itself.",
    sizeof(jde_float32), 4u, jde_float32_fields};

/** std_msgs/msg/Float64: A number by itself. */
typedef struct jde_float64 {
    /** The value. */
    double data;
} jde_float64;

typedef char jde_float64_has_its_size[sizeof(jde_float64) == 8 ? 1 : -1];

static const jde_field jde_float64_fields[] = {
    JDE_FIELD("data", offsetof(jde_float64, data), 0u, JDE_F64, JDE_ONE, 1u,
              "The value.", "", NULL),
};
static const jde_type jde_float64_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_float64_fields), "std_msgs/msg/Float64", "A number by itself.",
    sizeof(jde_float64), 8u, jde_float64_fields};

/** builtin_interfaces/msg/Time: A time, in seconds and nanoseconds since the application's start. */
typedef struct jde_time {
    /** Whole seconds. [s] */
    int32_t sec;
    /** Remaining nanoseconds, below 10^9. [ns] */
    uint32_t nanosec;
} jde_time;

typedef char jde_time_has_its_size[sizeof(jde_time) == 8 ? 1 : -1];

static const jde_field jde_time_fields[] = {
    JDE_FIELD("sec", offsetof(jde_time, sec), 0u, JDE_I32, JDE_ONE, 1u,
              "Whole seconds.", "s", NULL),
    JDE_FIELD("nanosec", offsetof(jde_time, nanosec), 0u, JDE_U32, JDE_ONE, 1u,
              "Remaining nanoseconds, below 10^9.", "ns", NULL),
};
static const jde_type jde_time_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_time_fields), "builtin_interfaces/msg/Time", "A time, in seconds and nanoseconds since the application's start.",
    sizeof(jde_time), 4u, jde_time_fields};

/** std_msgs/msg/Header: Time and frame of a measurement. */
typedef struct jde_header {
    /** Time of the measurement. */
    jde_time stamp;
    /** Frame of the coordinates. */
    struct { uint32_t length; char bytes[52]; } frame_id;
} jde_header;

typedef char jde_header_has_its_size[sizeof(jde_header) == 64 ? 1 : -1];

static const jde_field jde_header_fields[] = {
    JDE_FIELD("stamp", offsetof(jde_header, stamp), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time of the measurement.", "", &jde_time_type),
    JDE_FIELD("frame_id", offsetof(jde_header, frame_id.bytes), offsetof(jde_header, frame_id.length), JDE_U8, JDE_TEXT, 52u,
              "Frame of the coordinates.", "", NULL),
};
static const jde_type jde_header_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_header_fields), "std_msgs/msg/Header", "Time and frame of a measurement.",
    sizeof(jde_header), 4u, jde_header_fields};

/** geometry_msgs/msg/Point: A point in space. */
typedef struct jde_point {
    /** Ahead. [m] */
    double x;
    /** To the left. [m] */
    double y;
    /** Up. [m] */
    double z;
} jde_point;

typedef char jde_point_has_its_size[sizeof(jde_point) == 24 ? 1 : -1];

static const jde_field jde_point_fields[] = {
    JDE_FIELD("x", offsetof(jde_point, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Ahead.", "m", NULL),
    JDE_FIELD("y", offsetof(jde_point, y), 0u, JDE_F64, JDE_ONE, 1u,
              "To the left.", "m", NULL),
    JDE_FIELD("z", offsetof(jde_point, z), 0u, JDE_F64, JDE_ONE, 1u,
              "Up.", "m", NULL),
};
static const jde_type jde_point_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_point_fields), "geometry_msgs/msg/Point", "A point in space.",
    sizeof(jde_point), 8u, jde_point_fields};

/** geometry_msgs/msg/Vector3: A vector in space; its unit is that of the field that contains it. */
typedef struct jde_vector3 {
    /** Component ahead, or about the axis ahead. */
    double x;
    /** Component to the left, or about the axis to the left. */
    double y;
    /** Component up, or about the axis up. */
    double z;
} jde_vector3;

typedef char jde_vector3_has_its_size[sizeof(jde_vector3) == 24 ? 1 : -1];

static const jde_field jde_vector3_fields[] = {
    JDE_FIELD("x", offsetof(jde_vector3, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Component ahead, or about the axis ahead.", "", NULL),
    JDE_FIELD("y", offsetof(jde_vector3, y), 0u, JDE_F64, JDE_ONE, 1u,
              "Component to the left, or about the axis to the left.", "", NULL),
    JDE_FIELD("z", offsetof(jde_vector3, z), 0u, JDE_F64, JDE_ONE, 1u,
              "Component up, or about the axis up.", "", NULL),
};
static const jde_type jde_vector3_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_vector3_fields), "geometry_msgs/msg/Vector3", "A vector in space; its unit is that of the field that contains it.",
    sizeof(jde_vector3), 8u, jde_vector3_fields};

/**
 * geometry_msgs/msg/Quaternion: An orientation in space, as a quaternion. Only its direction counts: `Quaternion::normalized` has length 1, and one
 * of zeros is no orientation.
 */
typedef struct jde_quaternion {
    double x;
    double y;
    double z;
    double w;
} jde_quaternion;

typedef char jde_quaternion_has_its_size[sizeof(jde_quaternion) == 32 ? 1 : -1];

static const jde_field jde_quaternion_fields[] = {
    JDE_FIELD("x", offsetof(jde_quaternion, x), 0u, JDE_F64, JDE_ONE, 1u,
              "", "", NULL),
    JDE_FIELD("y", offsetof(jde_quaternion, y), 0u, JDE_F64, JDE_ONE, 1u,
              "", "", NULL),
    JDE_FIELD("z", offsetof(jde_quaternion, z), 0u, JDE_F64, JDE_ONE, 1u,
              "", "", NULL),
    JDE_FIELD("w", offsetof(jde_quaternion, w), 0u, JDE_F64, JDE_ONE, 1u,
              "", "", NULL),
};
static const jde_type jde_quaternion_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_quaternion_fields), "geometry_msgs/msg/Quaternion", "An orientation in space, as a quaternion. Only its direction counts: `Quaternion::normalized` has length 1, and one\nof zeros is no orientation.",
    sizeof(jde_quaternion), 8u, jde_quaternion_fields};

/** geometry_msgs/msg/Pose: A position and an orientation in space. */
typedef struct jde_pose {
    /** Position. */
    jde_point position;
    /** Orientation. */
    jde_quaternion orientation;
} jde_pose;

typedef char jde_pose_has_its_size[sizeof(jde_pose) == 56 ? 1 : -1];

static const jde_field jde_pose_fields[] = {
    JDE_FIELD("position", offsetof(jde_pose, position), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Position.", "", &jde_point_type),
    JDE_FIELD("orientation", offsetof(jde_pose, orientation), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Orientation.", "", &jde_quaternion_type),
};
static const jde_type jde_pose_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_pose_fields), "geometry_msgs/msg/Pose", "A position and an orientation in space.",
    sizeof(jde_pose), 8u, jde_pose_fields};

/** geometry_msgs/msg/PoseStamped: A pose with its time and frame. */
typedef struct jde_pose_stamped {
    /** Time and frame. */
    jde_header header;
    /** The pose. */
    jde_pose pose;
} jde_pose_stamped;

typedef char jde_pose_stamped_has_its_size[sizeof(jde_pose_stamped) == 120 ? 1 : -1];

static const jde_field jde_pose_stamped_fields[] = {
    JDE_FIELD("header", offsetof(jde_pose_stamped, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time and frame.", "", &jde_header_type),
    JDE_FIELD("pose", offsetof(jde_pose_stamped, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The pose.", "", &jde_pose_type),
};
static const jde_type jde_pose_stamped_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_pose_stamped_fields), "geometry_msgs/msg/PoseStamped", "A pose with its time and frame.",
    sizeof(jde_pose_stamped), 8u, jde_pose_stamped_fields};

/** geometry_msgs/msg/PoseWithCovariance: A pose with its covariance. */
typedef struct jde_pose_with_covariance {
    /** The pose. */
    jde_pose pose;
    /** 6 × 6, row by row, for x, y, z and the rotations about them. */
    double covariance[36];
} jde_pose_with_covariance;

typedef char jde_pose_with_covariance_has_its_size[sizeof(jde_pose_with_covariance) == 344 ? 1 : -1];

static const jde_field jde_pose_with_covariance_fields[] = {
    JDE_FIELD("pose", offsetof(jde_pose_with_covariance, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The pose.", "", &jde_pose_type),
    JDE_FIELD("covariance", offsetof(jde_pose_with_covariance, covariance), 0u, JDE_F64, JDE_ARRAY, 36u,
              "6 × 6, row by row, for x, y, z and the rotations about them.", "", NULL),
};
static const jde_type jde_pose_with_covariance_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_pose_with_covariance_fields), "geometry_msgs/msg/PoseWithCovariance", "A pose with its covariance.",
    sizeof(jde_pose_with_covariance), 8u, jde_pose_with_covariance_fields};

/** jde_msgs/msg/Point2D: A position in the plane. */
typedef struct jde_point2d {
    /** Ahead of the frame's origin. [m] */
    double x;
    /** Left of the frame's origin. [m] */
    double y;
} jde_point2d;

typedef char jde_point2d_has_its_size[sizeof(jde_point2d) == 16 ? 1 : -1];

static const jde_field jde_point2d_fields[] = {
    JDE_FIELD("x", offsetof(jde_point2d, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Ahead of the frame's origin.", "m", NULL),
    JDE_FIELD("y", offsetof(jde_point2d, y), 0u, JDE_F64, JDE_ONE, 1u,
              "Left of the frame's origin.", "m", NULL),
};
static const jde_type jde_point2d_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_point2d_fields), "jde_msgs/msg/Point2D", "A position in the plane.",
    sizeof(jde_point2d), 8u, jde_point2d_fields};

/** geometry_msgs/msg/Pose2D: A position and a heading in the plane. */
typedef struct jde_pose2d {
    /** Ahead of the frame's origin. [m] */
    double x;
    /** Left of the frame's origin. [m] */
    double y;
    /** Heading, counter-clockwise from the x axis. [rad] */
    double theta;
} jde_pose2d;

typedef char jde_pose2d_has_its_size[sizeof(jde_pose2d) == 24 ? 1 : -1];

static const jde_field jde_pose2d_fields[] = {
    JDE_FIELD("x", offsetof(jde_pose2d, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Ahead of the frame's origin.", "m", NULL),
    JDE_FIELD("y", offsetof(jde_pose2d, y), 0u, JDE_F64, JDE_ONE, 1u,
              "Left of the frame's origin.", "m", NULL),
    JDE_FIELD("theta", offsetof(jde_pose2d, theta), 0u, JDE_F64, JDE_ONE, 1u,
              "Heading, counter-clockwise from the x axis.", "rad", NULL),
};
static const jde_type jde_pose2d_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_pose2d_fields), "geometry_msgs/msg/Pose2D", "A position and a heading in the plane.",
    sizeof(jde_pose2d), 8u, jde_pose2d_fields};

/** geometry_msgs/msg/Transform: Translation and rotation of a frame in another one. */
typedef struct jde_transform {
    /** Position of the frame's origin. [m] */
    jde_vector3 translation;
    /** Orientation of the frame. */
    jde_quaternion rotation;
} jde_transform;

typedef char jde_transform_has_its_size[sizeof(jde_transform) == 56 ? 1 : -1];

static const jde_field jde_transform_fields[] = {
    JDE_FIELD("translation", offsetof(jde_transform, translation), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Position of the frame's origin.", "m", &jde_vector3_type),
    JDE_FIELD("rotation", offsetof(jde_transform, rotation), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Orientation of the frame.", "", &jde_quaternion_type),
};
static const jde_type jde_transform_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_transform_fields), "geometry_msgs/msg/Transform", "Translation and rotation of a frame in another one.",
    sizeof(jde_transform), 8u, jde_transform_fields};

/** geometry_msgs/msg/TransformStamped: Where a frame is in another one at a time. */
typedef struct jde_transform_stamped {
    /** Time, and the frame in which the transform is stated. */
    jde_header header;
    /** The frame that is there. */
    struct { uint32_t length; char bytes[52]; } child_frame_id;
    /** Where it is. */
    jde_transform transform;
} jde_transform_stamped;

typedef char jde_transform_stamped_has_its_size[sizeof(jde_transform_stamped) == 176 ? 1 : -1];

static const jde_field jde_transform_stamped_fields[] = {
    JDE_FIELD("header", offsetof(jde_transform_stamped, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame in which the transform is stated.", "", &jde_header_type),
    JDE_FIELD("child_frame_id", offsetof(jde_transform_stamped, child_frame_id.bytes), offsetof(jde_transform_stamped, child_frame_id.length), JDE_U8, JDE_TEXT, 52u,
              "The frame that is there.", "", NULL),
    JDE_FIELD("transform", offsetof(jde_transform_stamped, transform), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Where it is.", "", &jde_transform_type),
};
static const jde_type jde_transform_stamped_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_transform_stamped_fields), "geometry_msgs/msg/TransformStamped", "Where a frame is in another one at a time.",
    sizeof(jde_transform_stamped), 8u, jde_transform_stamped_fields};

/** geometry_msgs/msg/Twist: A velocity in space, commanded or measured. */
typedef struct jde_twist {
    /** Linear velocity, m/s. [m/s] */
    jde_vector3 linear;
    /** Angular velocity, rad/s. [rad/s] */
    jde_vector3 angular;
} jde_twist;

typedef char jde_twist_has_its_size[sizeof(jde_twist) == 48 ? 1 : -1];

static const jde_field jde_twist_fields[] = {
    JDE_FIELD("linear", offsetof(jde_twist, linear), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Linear velocity, m/s.", "m/s", &jde_vector3_type),
    JDE_FIELD("angular", offsetof(jde_twist, angular), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Angular velocity, rad/s.", "rad/s", &jde_vector3_type),
};
static const jde_type jde_twist_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_twist_fields), "geometry_msgs/msg/Twist", "A velocity in space, commanded or measured.",
    sizeof(jde_twist), 8u, jde_twist_fields};

/** geometry_msgs/msg/TwistWithCovariance: A velocity with its covariance. */
typedef struct jde_twist_with_covariance {
    /** The velocity. */
    jde_twist twist;
    /** 6 × 6, row by row, for x, y, z and the rotations about them. */
    double covariance[36];
} jde_twist_with_covariance;

typedef char jde_twist_with_covariance_has_its_size[sizeof(jde_twist_with_covariance) == 336 ? 1 : -1];

static const jde_field jde_twist_with_covariance_fields[] = {
    JDE_FIELD("twist", offsetof(jde_twist_with_covariance, twist), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The velocity.", "", &jde_twist_type),
    JDE_FIELD("covariance", offsetof(jde_twist_with_covariance, covariance), 0u, JDE_F64, JDE_ARRAY, 36u,
              "6 × 6, row by row, for x, y, z and the rotations about them.", "", NULL),
};
static const jde_type jde_twist_with_covariance_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_twist_with_covariance_fields), "geometry_msgs/msg/TwistWithCovariance", "A velocity with its covariance.",
    sizeof(jde_twist_with_covariance), 8u, jde_twist_with_covariance_fields};

/**
 * jde_msgs/msg/Chunk: Future commands of a base, made of what was seen at one instant: the time of the value. It is no command. A motor schema
 * that imports it gives each of its commands when it comes due.
 */
typedef struct jde_chunk {
    /** From one command to the next. The first is due at the time of the value; the last is meant for as long as the others. [s] */
    double spacing;
    /** How sure its maker is, from 0 (not at all) to 1. */
    double certainty;
    /** The weight of each chunk in a blend, as a share of the weight of the chunk before it. */
    double blend;
    /** How many chunks before it its commands are blended with; 0 if it replaces them. */
    uint32_t blended;
    uint8_t padding_28[4];
    /** The commands, in the order in which they come due. */
    struct { uint32_t length; uint32_t spare; jde_twist items[128]; } commands;
} jde_chunk;

typedef char jde_chunk_has_its_size[sizeof(jde_chunk) == 6184 ? 1 : -1];

static const jde_field jde_chunk_fields[] = {
    JDE_FIELD("spacing", offsetof(jde_chunk, spacing), 0u, JDE_F64, JDE_ONE, 1u,
              "From one command to the next. The first is due at the time of the value; the last is meant for as long as the others.", "s", NULL),
    JDE_FIELD("certainty", offsetof(jde_chunk, certainty), 0u, JDE_F64, JDE_ONE, 1u,
              "How sure its maker is, from 0 (not at all) to 1.", "", NULL),
    JDE_FIELD("blend", offsetof(jde_chunk, blend), 0u, JDE_F64, JDE_ONE, 1u,
              "The weight of each chunk in a blend, as a share of the weight of the chunk before it.", "", NULL),
    JDE_FIELD("blended", offsetof(jde_chunk, blended), 0u, JDE_U32, JDE_ONE, 1u,
              "How many chunks before it its commands are blended with; 0 if it replaces them.", "", NULL),
    JDE_FIELD("_", offsetof(jde_chunk, padding_28), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("commands", offsetof(jde_chunk, commands.items), offsetof(jde_chunk, commands.length), JDE_STRUCT, JDE_SEQUENCE, 128u,
              "The commands, in the order in which they come due.", "", &jde_twist_type),
};
static const jde_type jde_chunk_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_chunk_fields), "jde_msgs/msg/Chunk", "Future commands of a base, made of what was seen at one instant: the time of the value. It is no command. A motor schema\nthat imports it gives each of its commands when it comes due.",
    sizeof(jde_chunk), 8u, jde_chunk_fields};

/** jde_msgs/msg/ChunkStep: A command of a chunk that came due. */
typedef struct jde_chunk_step {
    /** The number of the chunk among those of its maker. */
    uint64_t chunk;
    /** How long before this step it was seen what the chunk is made of. [s] */
    double age;
    /** The place of the command in the chunk, from 1. */
    uint32_t step;
    /** How many commands the chunk has. */
    uint32_t steps;
    /** How many chunks before it have a share in the command. */
    uint32_t blended;
    uint8_t padding_28[4];
    /** The command, as it was given: before limits and the judgement of guards. */
    jde_twist command;
} jde_chunk_step;

typedef char jde_chunk_step_has_its_size[sizeof(jde_chunk_step) == 80 ? 1 : -1];

static const jde_field jde_chunk_step_fields[] = {
    JDE_FIELD("chunk", offsetof(jde_chunk_step, chunk), 0u, JDE_U64, JDE_ONE, 1u,
              "The number of the chunk among those of its maker.", "", NULL),
    JDE_FIELD("age", offsetof(jde_chunk_step, age), 0u, JDE_F64, JDE_ONE, 1u,
              "How long before this step it was seen what the chunk is made of.", "s", NULL),
    JDE_FIELD("step", offsetof(jde_chunk_step, step), 0u, JDE_U32, JDE_ONE, 1u,
              "The place of the command in the chunk, from 1.", "", NULL),
    JDE_FIELD("steps", offsetof(jde_chunk_step, steps), 0u, JDE_U32, JDE_ONE, 1u,
              "How many commands the chunk has.", "", NULL),
    JDE_FIELD("blended", offsetof(jde_chunk_step, blended), 0u, JDE_U32, JDE_ONE, 1u,
              "How many chunks before it have a share in the command.", "", NULL),
    JDE_FIELD("_", offsetof(jde_chunk_step, padding_28), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("command", offsetof(jde_chunk_step, command), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The command, as it was given: before limits and the judgement of guards.", "", &jde_twist_type),
};
static const jde_type jde_chunk_step_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_chunk_step_fields), "jde_msgs/msg/ChunkStep", "A command of a chunk that came due.",
    sizeof(jde_chunk_step), 8u, jde_chunk_step_fields};

/** nav_msgs/msg/Odometry: Pose and velocity, as measured by the wheels. */
typedef struct jde_odometry {
    /** Time, and the frame of the pose: "odom". */
    jde_header header;
    /** The frame of the velocity: "base_link". */
    struct { uint32_t length; char bytes[52]; } child_frame_id;
    /** Pose of the base, in the frame of the header. */
    jde_pose_with_covariance pose;
    /** Velocity of the base, in its own frame. */
    jde_twist_with_covariance twist;
} jde_odometry;

typedef char jde_odometry_has_its_size[sizeof(jde_odometry) == 800 ? 1 : -1];

static const jde_field jde_odometry_fields[] = {
    JDE_FIELD("header", offsetof(jde_odometry, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the pose: \"odom\".", "", &jde_header_type),
    JDE_FIELD("child_frame_id", offsetof(jde_odometry, child_frame_id.bytes), offsetof(jde_odometry, child_frame_id.length), JDE_U8, JDE_TEXT, 52u,
              "The frame of the velocity: \"base_link\".", "", NULL),
    JDE_FIELD("pose", offsetof(jde_odometry, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Pose of the base, in the frame of the header.", "", &jde_pose_with_covariance_type),
    JDE_FIELD("twist", offsetof(jde_odometry, twist), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Velocity of the base, in its own frame.", "", &jde_twist_with_covariance_type),
};
static const jde_type jde_odometry_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_odometry_fields), "nav_msgs/msg/Odometry", "Pose and velocity, as measured by the wheels.",
    sizeof(jde_odometry), 8u, jde_odometry_fields};

/** nav_msgs/msg/MapMetaData: Size, resolution and origin of a map. */
typedef struct jde_map_meta_data {
    /** Time at which the map was loaded. */
    jde_time map_load_time;
    /** Side of a cell. [m] */
    float resolution;
    /** Columns. */
    uint32_t width;
    /** Rows. */
    uint32_t height;
    uint8_t padding_20[4];
    /** Pose of the lower left corner of the first cell. */
    jde_pose origin;
} jde_map_meta_data;

typedef char jde_map_meta_data_has_its_size[sizeof(jde_map_meta_data) == 80 ? 1 : -1];

static const jde_field jde_map_meta_data_fields[] = {
    JDE_FIELD("map_load_time", offsetof(jde_map_meta_data, map_load_time), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time at which the map was loaded.", "", &jde_time_type),
    JDE_FIELD("resolution", offsetof(jde_map_meta_data, resolution), 0u, JDE_F32, JDE_ONE, 1u,
              "Side of a cell.", "m", NULL),
    JDE_FIELD("width", offsetof(jde_map_meta_data, width), 0u, JDE_U32, JDE_ONE, 1u,
              "Columns.", "", NULL),
    JDE_FIELD("height", offsetof(jde_map_meta_data, height), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows.", "", NULL),
    JDE_FIELD("_", offsetof(jde_map_meta_data, padding_20), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("origin", offsetof(jde_map_meta_data, origin), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Pose of the lower left corner of the first cell.", "", &jde_pose_type),
};
static const jde_type jde_map_meta_data_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_map_meta_data_fields), "nav_msgs/msg/MapMetaData", "Size, resolution and origin of a map.",
    sizeof(jde_map_meta_data), 8u, jde_map_meta_data_fields};

/**
 * nav_msgs/msg/OccupancyGrid: A map of up to 4096 × 4096 cells: 200 m at 5 cm. Cells that a map does not have cost no memory. A stack has no
 * room for this type: fill a loan, or memory of the heap.
 */
typedef struct jde_occupancy_grid {
    /** Time, and the frame of the origin. */
    jde_header header;
    /** Size, resolution and origin. */
    jde_map_meta_data info;
    /**
     * The cells, row by row from the origin: 0 to 100 is the probability of an obstacle in percent, -1
     * unknown.
     */
    struct { uint32_t length; uint32_t spare; int8_t items[16777216]; } data;
} jde_occupancy_grid;

typedef char jde_occupancy_grid_has_its_size[sizeof(jde_occupancy_grid) == 16777368 ? 1 : -1];

static const jde_field jde_occupancy_grid_fields[] = {
    JDE_FIELD("header", offsetof(jde_occupancy_grid, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the origin.", "", &jde_header_type),
    JDE_FIELD("info", offsetof(jde_occupancy_grid, info), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Size, resolution and origin.", "", &jde_map_meta_data_type),
    JDE_FIELD("data", offsetof(jde_occupancy_grid, data.items), offsetof(jde_occupancy_grid, data.length), JDE_I8, JDE_SEQUENCE, 16777216u,
              "The cells, row by row from the origin: 0 to 100 is the probability of an obstacle in percent, -1\nunknown.", "", NULL),
};
static const jde_type jde_occupancy_grid_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_occupancy_grid_fields), "nav_msgs/msg/OccupancyGrid", "A map of up to 4096 × 4096 cells: 200 m at 5 cm. Cells that a map does not have cost no memory. A stack has no\nroom for this type: fill a loan, or memory of the heap.",
    sizeof(jde_occupancy_grid), 8u, jde_occupancy_grid_fields};

/** nav_msgs/msg/Path: A path to follow, of up to 256 poses: ways through a building turn more often than 64 times. */
typedef struct jde_path {
    /** Time and frame. */
    jde_header header;
    /** The poses, from first to last. */
    struct { uint32_t length; uint32_t spare; jde_pose_stamped items[256]; } poses;
} jde_path;

typedef char jde_path_has_its_size[sizeof(jde_path) == 30792 ? 1 : -1];

static const jde_field jde_path_fields[] = {
    JDE_FIELD("header", offsetof(jde_path, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time and frame.", "", &jde_header_type),
    JDE_FIELD("poses", offsetof(jde_path, poses.items), offsetof(jde_path, poses.length), JDE_STRUCT, JDE_SEQUENCE, 256u,
              "The poses, from first to last.", "", &jde_pose_stamped_type),
};
static const jde_type jde_path_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_path_fields), "nav_msgs/msg/Path", "A path to follow, of up to 256 poses: ways through a building turn more often than 64 times.",
    sizeof(jde_path), 8u, jde_path_fields};

/** jde_msgs/msg/Route: Targets in the plane, in a form for files; ROS tools draw a `Path`. */
typedef struct jde_route {
    /** The targets, from first to last. */
    struct { uint32_t length; uint32_t spare; jde_pose2d items[64]; } poses;
} jde_route;

typedef char jde_route_has_its_size[sizeof(jde_route) == 1544 ? 1 : -1];

static const jde_field jde_route_fields[] = {
    JDE_FIELD("poses", offsetof(jde_route, poses.items), offsetof(jde_route, poses.length), JDE_STRUCT, JDE_SEQUENCE, 64u,
              "The targets, from first to last.", "", &jde_pose2d_type),
};
static const jde_type jde_route_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_route_fields), "jde_msgs/msg/Route", "Targets in the plane, in a form for files; ROS tools draw a `Path`.",
    sizeof(jde_route), 8u, jde_route_fields};

/** jde_msgs/msg/Start: An optional pose at which a robot starts, in a form for files: `[[3.55, 1.6, "90 deg"]]`, or `[]` for none. */
typedef struct jde_start {
    /** The pose, in the frame of the world or of the map. */
    struct { uint32_t length; uint32_t spare; jde_pose2d items[1]; } pose;
} jde_start;

typedef char jde_start_has_its_size[sizeof(jde_start) == 32 ? 1 : -1];

static const jde_field jde_start_fields[] = {
    JDE_FIELD("pose", offsetof(jde_start, pose.items), offsetof(jde_start, pose.length), JDE_STRUCT, JDE_SEQUENCE, 1u,
              "The pose, in the frame of the world or of the map.", "", &jde_pose2d_type),
};
static const jde_type jde_start_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_start_fields), "jde_msgs/msg/Start", "An optional pose at which a robot starts, in a form for files: `[[3.55, 1.6, \"90 deg\"]]`, or `[]` for none.",
    sizeof(jde_start), 8u, jde_start_fields};

/** jde_msgs/msg/Target: An optional target: a place, or a pose if its heading counts. */
typedef struct jde_target {
    /** The position and the heading, in the frame of the odometry. */
    jde_pose2d pose;
    /** Whether there is a target. */
    uint8_t set;
    /** Whether its heading counts. Otherwise the robot may face anywhere. */
    uint8_t has_heading;
    uint8_t padding_26[6];
} jde_target;

typedef char jde_target_has_its_size[sizeof(jde_target) == 32 ? 1 : -1];

static const jde_field jde_target_fields[] = {
    JDE_FIELD("pose", offsetof(jde_target, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The position and the heading, in the frame of the odometry.", "", &jde_pose2d_type),
    JDE_FIELD("set", offsetof(jde_target, set), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether there is a target.", "", NULL),
    JDE_FIELD("has_heading", offsetof(jde_target, has_heading), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether its heading counts. Otherwise the robot may face anywhere.", "", NULL),
    JDE_FIELD("_", offsetof(jde_target, padding_26), 0u, JDE_U8, JDE_PADDING, 6u, "", "", NULL),
};
static const jde_type jde_target_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_target_fields), "jde_msgs/msg/Target", "An optional target: a place, or a pose if its heading counts.",
    sizeof(jde_target), 8u, jde_target_fields};

/** jde_msgs/msg/Footprint: The outline of a robot on the floor: in files `{ radius = 0.25 }`, or `{ points = [[0.3, 0.2], ...] }`. */
typedef struct jde_footprint {
    /** Radius of the circle around the origin of the base; not used if there are points. [m] */
    double radius;
    /** The corners of a convex polygon in the frame of the base, in order; none for a circle. */
    struct { uint32_t length; uint32_t spare; jde_point2d items[32]; } points;
} jde_footprint;

typedef char jde_footprint_has_its_size[sizeof(jde_footprint) == 528 ? 1 : -1];

static const jde_field jde_footprint_fields[] = {
    JDE_FIELD("radius", offsetof(jde_footprint, radius), 0u, JDE_F64, JDE_ONE, 1u,
              "Radius of the circle around the origin of the base; not used if there are points.", "m", NULL),
    JDE_FIELD("points", offsetof(jde_footprint, points.items), offsetof(jde_footprint, points.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "The corners of a convex polygon in the frame of the base, in order; none for a circle.", "", &jde_point2d_type),
};
static const jde_type jde_footprint_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_footprint_fields), "jde_msgs/msg/Footprint", "The outline of a robot on the floor: in files `{ radius = 0.25 }`, or `{ points = [[0.3, 0.2], ...] }`.",
    sizeof(jde_footprint), 8u, jde_footprint_fields};

/** jde_msgs/msg/Mount: Where a sensor is on a robot. */
typedef struct jde_mount {
    /** The frame of the sensor, as in the headers of its values. */
    struct { uint32_t length; char bytes[52]; } frame;
    /** Its pose in the frame of the base. */
    jde_pose2d pose;
} jde_mount;

typedef char jde_mount_has_its_size[sizeof(jde_mount) == 80 ? 1 : -1];

static const jde_field jde_mount_fields[] = {
    JDE_FIELD("frame", offsetof(jde_mount, frame.bytes), offsetof(jde_mount, frame.length), JDE_U8, JDE_TEXT, 52u,
              "The frame of the sensor, as in the headers of its values.", "", NULL),
    JDE_FIELD("pose", offsetof(jde_mount, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Its pose in the frame of the base.", "", &jde_pose2d_type),
};
static const jde_type jde_mount_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_mount_fields), "jde_msgs/msg/Mount", "Where a sensor is on a robot.",
    sizeof(jde_mount), 8u, jde_mount_fields};

/** jde_msgs/msg/Body: The body of a robot, for windows and pictures. A driver publishes it once it is known. */
typedef struct jde_body {
    /** Time, and the frame of the base. */
    jde_header header;
    /** The outline; a circle of radius 0 if it is unknown. */
    jde_footprint footprint;
    /** Where its lasers are. */
    struct { uint32_t length; uint32_t spare; jde_mount items[8]; } lasers;
} jde_body;

typedef char jde_body_has_its_size[sizeof(jde_body) == 1240 ? 1 : -1];

static const jde_field jde_body_fields[] = {
    JDE_FIELD("header", offsetof(jde_body, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the base.", "", &jde_header_type),
    JDE_FIELD("footprint", offsetof(jde_body, footprint), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The outline; a circle of radius 0 if it is unknown.", "", &jde_footprint_type),
    JDE_FIELD("lasers", offsetof(jde_body, lasers.items), offsetof(jde_body, lasers.length), JDE_STRUCT, JDE_SEQUENCE, 8u,
              "Where its lasers are.", "", &jde_mount_type),
};
static const jde_type jde_body_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_body_fields), "jde_msgs/msg/Body", "The body of a robot, for windows and pictures. A driver publishes it once it is known.",
    sizeof(jde_body), 8u, jde_body_fields};

/** jde_msgs/msg/Zone: An area of the floor: a polygon, in files `{ corners = [[1, 1], [2, 1], [2, 2]] }`. */
typedef struct jde_zone {
    /** At least three corners, in order, in the frame of the map. The last is connected to the first. */
    struct { uint32_t length; uint32_t spare; jde_point2d items[32]; } corners;
} jde_zone;

typedef char jde_zone_has_its_size[sizeof(jde_zone) == 520 ? 1 : -1];

static const jde_field jde_zone_fields[] = {
    JDE_FIELD("corners", offsetof(jde_zone, corners.items), offsetof(jde_zone, corners.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "At least three corners, in order, in the frame of the map. The last is connected to the first.", "", &jde_point2d_type),
};
static const jde_type jde_zone_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_zone_fields), "jde_msgs/msg/Zone", "An area of the floor: a polygon, in files `{ corners = [[1, 1], [2, 1], [2, 2]] }`.",
    sizeof(jde_zone), 8u, jde_zone_fields};

/** jde_msgs/msg/Zones: Areas of the floor, of which up to 16 fit: in files `{ zones = [{ corners = [[1, 1], ...] }, ...] }`. */
typedef struct jde_zones {
    /** The areas; they may overlap. */
    struct { uint32_t length; uint32_t spare; jde_zone items[16]; } zones;
} jde_zones;

typedef char jde_zones_has_its_size[sizeof(jde_zones) == 8328 ? 1 : -1];

static const jde_field jde_zones_fields[] = {
    JDE_FIELD("zones", offsetof(jde_zones, zones.items), offsetof(jde_zones, zones.length), JDE_STRUCT, JDE_SEQUENCE, 16u,
              "The areas; they may overlap.", "", &jde_zone_type),
};
static const jde_type jde_zones_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_zones_fields), "jde_msgs/msg/Zones", "Areas of the floor, of which up to 16 fit: in files `{ zones = [{ corners = [[1, 1], ...] }, ...] }`.",
    sizeof(jde_zones), 8u, jde_zones_fields};

/** jde_msgs/msg/Strip: A strip of the floor: a line with a width, in files `{ width = 0.6, points = [[1, 1], [4, 1]] }`. */
typedef struct jde_strip {
    /** The width. [m] */
    double width;
    /** At least two points, in order, in the frame of the map. */
    struct { uint32_t length; uint32_t spare; jde_point2d items[32]; } points;
} jde_strip;

typedef char jde_strip_has_its_size[sizeof(jde_strip) == 528 ? 1 : -1];

static const jde_field jde_strip_fields[] = {
    JDE_FIELD("width", offsetof(jde_strip, width), 0u, JDE_F64, JDE_ONE, 1u,
              "The width.", "m", NULL),
    JDE_FIELD("points", offsetof(jde_strip, points.items), offsetof(jde_strip, points.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "At least two points, in order, in the frame of the map.", "", &jde_point2d_type),
};
static const jde_type jde_strip_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_strip_fields), "jde_msgs/msg/Strip", "A strip of the floor: a line with a width, in files `{ width = 0.6, points = [[1, 1], [4, 1]] }`.",
    sizeof(jde_strip), 8u, jde_strip_fields};

/**
 * jde_msgs/msg/Lanes: Lanes, the strips that paths prefer, of which up to 16 fit: in files
 * `{ lanes = [{ width = 0.6, points = [[1, 1], ...] }, ...] }`.
 */
typedef struct jde_lanes {
    /** The strips; they may cross and overlap. */
    struct { uint32_t length; uint32_t spare; jde_strip items[16]; } lanes;
} jde_lanes;

typedef char jde_lanes_has_its_size[sizeof(jde_lanes) == 8456 ? 1 : -1];

static const jde_field jde_lanes_fields[] = {
    JDE_FIELD("lanes", offsetof(jde_lanes, lanes.items), offsetof(jde_lanes, lanes.length), JDE_STRUCT, JDE_SEQUENCE, 16u,
              "The strips; they may cross and overlap.", "", &jde_strip_type),
};
static const jde_type jde_lanes_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_lanes_fields), "jde_msgs/msg/Lanes", "Lanes, the strips that paths prefer, of which up to 16 fit: in files\n`{ lanes = [{ width = 0.6, points = [[1, 1], ...] }, ...] }`.",
    sizeof(jde_lanes), 8u, jde_lanes_fields};

/** sensor_msgs/msg/LaserScan: One scan of a laser scanner with up to 1088 beams. */
typedef struct jde_laser_scan {
    /** Time of the first beam, and the frame of the scanner: x ahead, angles counter-clockwise about z. */
    jde_header header;
    /** Angle of the first beam. [rad] */
    float angle_min;
    /** Angle of the last beam. [rad] */
    float angle_max;
    /** Angle from one beam to the next. [rad] */
    float angle_increment;
    /** Time from one beam to the next. [s] */
    float time_increment;
    /** Time from one scan to the next. [s] */
    float scan_time;
    /** Least measurable distance. [m] */
    float range_min;
    /** Greatest measurable distance. [m] */
    float range_max;
    /** Distances, in the order of the beams. [m] */
    struct { uint32_t length; uint32_t spare; float items[1088]; } ranges;
    /** Intensities, in units of the device; empty if it has none. */
    struct { uint32_t length; uint32_t spare; float items[1088]; } intensities;
} jde_laser_scan;

typedef char jde_laser_scan_has_its_size[sizeof(jde_laser_scan) == 8812 ? 1 : -1];

static const jde_field jde_laser_scan_fields[] = {
    JDE_FIELD("header", offsetof(jde_laser_scan, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time of the first beam, and the frame of the scanner: x ahead, angles counter-clockwise about z.", "", &jde_header_type),
    JDE_FIELD("angle_min", offsetof(jde_laser_scan, angle_min), 0u, JDE_F32, JDE_ONE, 1u,
              "Angle of the first beam.", "rad", NULL),
    JDE_FIELD("angle_max", offsetof(jde_laser_scan, angle_max), 0u, JDE_F32, JDE_ONE, 1u,
              "Angle of the last beam.", "rad", NULL),
    JDE_FIELD("angle_increment", offsetof(jde_laser_scan, angle_increment), 0u, JDE_F32, JDE_ONE, 1u,
              "Angle from one beam to the next.", "rad", NULL),
    JDE_FIELD("time_increment", offsetof(jde_laser_scan, time_increment), 0u, JDE_F32, JDE_ONE, 1u,
              "Time from one beam to the next.", "s", NULL),
    JDE_FIELD("scan_time", offsetof(jde_laser_scan, scan_time), 0u, JDE_F32, JDE_ONE, 1u,
              "Time from one scan to the next.", "s", NULL),
    JDE_FIELD("range_min", offsetof(jde_laser_scan, range_min), 0u, JDE_F32, JDE_ONE, 1u,
              "Least measurable distance.", "m", NULL),
    JDE_FIELD("range_max", offsetof(jde_laser_scan, range_max), 0u, JDE_F32, JDE_ONE, 1u,
              "Greatest measurable distance.", "m", NULL),
    JDE_FIELD("ranges", offsetof(jde_laser_scan, ranges.items), offsetof(jde_laser_scan, ranges.length), JDE_F32, JDE_SEQUENCE, 1088u,
              "Distances, in the order of the beams.", "m", NULL),
    JDE_FIELD("intensities", offsetof(jde_laser_scan, intensities.items), offsetof(jde_laser_scan, intensities.length), JDE_F32, JDE_SEQUENCE, 1088u,
              "Intensities, in units of the device; empty if it has none.", "", NULL),
};
static const jde_type jde_laser_scan_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_laser_scan_fields), "sensor_msgs/msg/LaserScan", "One scan of a laser scanner with up to 1088 beams.",
    sizeof(jde_laser_scan), 4u, jde_laser_scan_fields};

/** sensor_msgs/msg/Range: One sonar or infrared sensor. */
typedef struct jde_range {
    /** Time, and the frame of the sensor: x ahead. */
    jde_header header;
    /** 0 ultrasound, 1 infrared. */
    uint8_t radiation_type;
    uint8_t padding_65[3];
    /** Angular width of the cone. [rad] */
    float field_of_view;
    /** Least measurable distance. [m] */
    float min_range;
    /** Greatest measurable distance. [m] */
    float max_range;
    /** Measured distance. [m] */
    float range;
    /** Variance of the distance; 0 if unknown. [m2] */
    float variance;
} jde_range;

typedef char jde_range_has_its_size[sizeof(jde_range) == 88 ? 1 : -1];

static const jde_field jde_range_fields[] = {
    JDE_FIELD("header", offsetof(jde_range, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the sensor: x ahead.", "", &jde_header_type),
    JDE_FIELD("radiation_type", offsetof(jde_range, radiation_type), 0u, JDE_U8, JDE_ONE, 1u,
              "0 ultrasound, 1 infrared.", "", NULL),
    JDE_FIELD("_", offsetof(jde_range, padding_65), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("field_of_view", offsetof(jde_range, field_of_view), 0u, JDE_F32, JDE_ONE, 1u,
              "Angular width of the cone.", "rad", NULL),
    JDE_FIELD("min_range", offsetof(jde_range, min_range), 0u, JDE_F32, JDE_ONE, 1u,
              "Least measurable distance.", "m", NULL),
    JDE_FIELD("max_range", offsetof(jde_range, max_range), 0u, JDE_F32, JDE_ONE, 1u,
              "Greatest measurable distance.", "m", NULL),
    JDE_FIELD("range", offsetof(jde_range, range), 0u, JDE_F32, JDE_ONE, 1u,
              "Measured distance.", "m", NULL),
    JDE_FIELD("variance", offsetof(jde_range, variance), 0u, JDE_F32, JDE_ONE, 1u,
              "Variance of the distance; 0 if unknown.", "m2", NULL),
};
static const jde_type jde_range_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_range_fields), "sensor_msgs/msg/Range", "One sonar or infrared sensor.",
    sizeof(jde_range), 4u, jde_range_fields};

/** jde_msgs/msg/RangeRing: A ring of up to 32 range sensors of one type around a base. */
typedef struct jde_range_ring {
    /** Time, and the frame of the base. */
    jde_header header;
    /** 0 ultrasound, 1 infrared. */
    uint8_t radiation_type;
    uint8_t padding_65[3];
    /** Angular width of each cone. [rad] */
    float field_of_view;
    /** Least measurable distance. [m] */
    float min_range;
    /** Greatest measurable distance. [m] */
    float max_range;
    /** Position and direction of each sensor, in the frame of the base. */
    struct { uint32_t length; uint32_t spare; jde_pose2d items[32]; } poses;
    /** Measured distance of each sensor. [m] */
    struct { uint32_t length; uint32_t spare; float items[32]; } ranges;
} jde_range_ring;

typedef char jde_range_ring_has_its_size[sizeof(jde_range_ring) == 992 ? 1 : -1];

static const jde_field jde_range_ring_fields[] = {
    JDE_FIELD("header", offsetof(jde_range_ring, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the base.", "", &jde_header_type),
    JDE_FIELD("radiation_type", offsetof(jde_range_ring, radiation_type), 0u, JDE_U8, JDE_ONE, 1u,
              "0 ultrasound, 1 infrared.", "", NULL),
    JDE_FIELD("_", offsetof(jde_range_ring, padding_65), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("field_of_view", offsetof(jde_range_ring, field_of_view), 0u, JDE_F32, JDE_ONE, 1u,
              "Angular width of each cone.", "rad", NULL),
    JDE_FIELD("min_range", offsetof(jde_range_ring, min_range), 0u, JDE_F32, JDE_ONE, 1u,
              "Least measurable distance.", "m", NULL),
    JDE_FIELD("max_range", offsetof(jde_range_ring, max_range), 0u, JDE_F32, JDE_ONE, 1u,
              "Greatest measurable distance.", "m", NULL),
    JDE_FIELD("poses", offsetof(jde_range_ring, poses.items), offsetof(jde_range_ring, poses.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "Position and direction of each sensor, in the frame of the base.", "", &jde_pose2d_type),
    JDE_FIELD("ranges", offsetof(jde_range_ring, ranges.items), offsetof(jde_range_ring, ranges.length), JDE_F32, JDE_SEQUENCE, 32u,
              "Measured distance of each sensor.", "m", NULL),
};
static const jde_type jde_range_ring_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_range_ring_fields), "jde_msgs/msg/RangeRing", "A ring of up to 32 range sensors of one type around a base.",
    sizeof(jde_range_ring), 8u, jde_range_ring_fields};

/** sensor_msgs/msg/Image: An image of up to 640 × 480 pixels of three bytes, or 640 × 360 depths. */
typedef struct jde_image {
    /** Time, and the frame of the camera: x to the right of the image, y down, z into it. */
    jde_header header;
    /** Rows. */
    uint32_t height;
    /** Columns. */
    uint32_t width;
    /** Format of a pixel: "rgb8", "bgr8", "mono8"; "32FC1" for a depth in metres (REP-118). */
    struct { uint32_t length; char bytes[28]; } encoding;
    /** Whether numbers of several bytes begin with the most significant byte. */
    uint8_t is_bigendian;
    uint8_t padding_105[3];
    /** Size of a row in bytes. */
    uint32_t step;
    /** Rows, from top to bottom. */
    struct { uint32_t length; uint32_t spare; uint8_t items[921600]; } data;
} jde_image;

typedef char jde_image_has_its_size[sizeof(jde_image) == 921720 ? 1 : -1];

static const jde_field jde_image_fields[] = {
    JDE_FIELD("header", offsetof(jde_image, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the camera: x to the right of the image, y down, z into it.", "", &jde_header_type),
    JDE_FIELD("height", offsetof(jde_image, height), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows.", "", NULL),
    JDE_FIELD("width", offsetof(jde_image, width), 0u, JDE_U32, JDE_ONE, 1u,
              "Columns.", "", NULL),
    JDE_FIELD("encoding", offsetof(jde_image, encoding.bytes), offsetof(jde_image, encoding.length), JDE_U8, JDE_TEXT, 28u,
              "Format of a pixel: \"rgb8\", \"bgr8\", \"mono8\"; \"32FC1\" for a depth in metres (REP-118).", "", NULL),
    JDE_FIELD("is_bigendian", offsetof(jde_image, is_bigendian), 0u, JDE_U8, JDE_ONE, 1u,
              "Whether numbers of several bytes begin with the most significant byte.", "", NULL),
    JDE_FIELD("_", offsetof(jde_image, padding_105), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("step", offsetof(jde_image, step), 0u, JDE_U32, JDE_ONE, 1u,
              "Size of a row in bytes.", "", NULL),
    JDE_FIELD("data", offsetof(jde_image, data.items), offsetof(jde_image, data.length), JDE_U8, JDE_SEQUENCE, 921600u,
              "Rows, from top to bottom.", "", NULL),
};
static const jde_type jde_image_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_image_fields), "sensor_msgs/msg/Image", "An image of up to 640 × 480 pixels of three bytes, or 640 × 360 depths.",
    sizeof(jde_image), 4u, jde_image_fields};

/** sensor_msgs/msg/CompressedImage: A compressed image of up to 1 MiB. A stack has no room for this type: fill a loan, or memory of the heap. */
typedef struct jde_compressed_image {
    /** Time, and the frame of the camera, as of an `Image`. */
    jde_header header;
    /** Format: "jpeg" or "png", perhaps within more words, as in "rgb8; jpeg compressed bgr8". */
    struct { uint32_t length; char bytes[60]; } format;
    /** A file of that format. */
    struct { uint32_t length; uint32_t spare; uint8_t items[1048576]; } data;
} jde_compressed_image;

typedef char jde_compressed_image_has_its_size[sizeof(jde_compressed_image) == 1048712 ? 1 : -1];

static const jde_field jde_compressed_image_fields[] = {
    JDE_FIELD("header", offsetof(jde_compressed_image, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the camera, as of an `Image`.", "", &jde_header_type),
    JDE_FIELD("format", offsetof(jde_compressed_image, format.bytes), offsetof(jde_compressed_image, format.length), JDE_U8, JDE_TEXT, 60u,
              "Format: \"jpeg\" or \"png\", perhaps within more words, as in \"rgb8; jpeg compressed bgr8\".", "", NULL),
    JDE_FIELD("data", offsetof(jde_compressed_image, data.items), offsetof(jde_compressed_image, data.length), JDE_U8, JDE_SEQUENCE, 1048576u,
              "A file of that format.", "", NULL),
};
static const jde_type jde_compressed_image_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_compressed_image_fields), "sensor_msgs/msg/CompressedImage", "A compressed image of up to 1 MiB. A stack has no room for this type: fill a loan, or memory of the heap.",
    sizeof(jde_compressed_image), 4u, jde_compressed_image_fields};

/** sensor_msgs/msg/RegionOfInterest: A rectangle of the pixels of a camera. */
typedef struct jde_region_of_interest {
    /** First column. [px] */
    uint32_t x_offset;
    /** First row. [px] */
    uint32_t y_offset;
    /** Rows; 0 for all. [px] */
    uint32_t height;
    /** Columns; 0 for all. [px] */
    uint32_t width;
    /** Whether the rectangle is of the rectified picture. */
    uint8_t do_rectify;
    uint8_t padding_17[3];
} jde_region_of_interest;

typedef char jde_region_of_interest_has_its_size[sizeof(jde_region_of_interest) == 20 ? 1 : -1];

static const jde_field jde_region_of_interest_fields[] = {
    JDE_FIELD("x_offset", offsetof(jde_region_of_interest, x_offset), 0u, JDE_U32, JDE_ONE, 1u,
              "First column.", "px", NULL),
    JDE_FIELD("y_offset", offsetof(jde_region_of_interest, y_offset), 0u, JDE_U32, JDE_ONE, 1u,
              "First row.", "px", NULL),
    JDE_FIELD("height", offsetof(jde_region_of_interest, height), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows; 0 for all.", "px", NULL),
    JDE_FIELD("width", offsetof(jde_region_of_interest, width), 0u, JDE_U32, JDE_ONE, 1u,
              "Columns; 0 for all.", "px", NULL),
    JDE_FIELD("do_rectify", offsetof(jde_region_of_interest, do_rectify), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether the rectangle is of the rectified picture.", "", NULL),
    JDE_FIELD("_", offsetof(jde_region_of_interest, padding_17), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
};
static const jde_type jde_region_of_interest_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_region_of_interest_fields), "sensor_msgs/msg/RegionOfInterest", "A rectangle of the pixels of a camera.",
    sizeof(jde_region_of_interest), 4u, jde_region_of_interest_fields};

/**
 * sensor_msgs/msg/CameraInfo: The calibration of a camera, as ROS has it beside its pictures (REP-104). The middle of the first pixel is at
 * 0, 0.
 */
typedef struct jde_camera_info {
    /** Time of the picture, and the frame of the camera. */
    jde_header header;
    /** Rows of the pictures of the calibration. [px] */
    uint32_t height;
    /** Columns of the pictures of the calibration. [px] */
    uint32_t width;
    /** Model of the distortion: "plumb_bob", "rational_polynomial" or "equidistant". */
    struct { uint32_t length; char bytes[28]; } distortion_model;
    /** Coefficients of the distortion, in the order of OpenCV: k1, k2, p1, p2, k3, ... */
    struct { uint32_t length; uint32_t spare; double items[14]; } d;
    /** Intrinsic matrix of the raw picture, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1. An fx of 0: uncalibrated. */
    double k[9];
    /** Rectification, row by row: the rotation to the frame of the rectified picture. */
    double r[9];
    /** Projection to the rectified picture, three rows of four: fx', 0, cx', Tx, 0, fy', cy', Ty, 0, 0, 1, 0. */
    double p[12];
    /** Columns of the camera in a column of the picture; 0 and 1 are the same. */
    uint32_t binning_x;
    /** Rows of the camera in a row of the picture; 0 and 1 are the same. */
    uint32_t binning_y;
    /** The part of the camera's pixels that the picture shows, before binning. */
    jde_region_of_interest roi;
    uint8_t padding_492[4];
} jde_camera_info;

typedef char jde_camera_info_has_its_size[sizeof(jde_camera_info) == 496 ? 1 : -1];

static const jde_field jde_camera_info_fields[] = {
    JDE_FIELD("header", offsetof(jde_camera_info, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time of the picture, and the frame of the camera.", "", &jde_header_type),
    JDE_FIELD("height", offsetof(jde_camera_info, height), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows of the pictures of the calibration.", "px", NULL),
    JDE_FIELD("width", offsetof(jde_camera_info, width), 0u, JDE_U32, JDE_ONE, 1u,
              "Columns of the pictures of the calibration.", "px", NULL),
    JDE_FIELD("distortion_model", offsetof(jde_camera_info, distortion_model.bytes), offsetof(jde_camera_info, distortion_model.length), JDE_U8, JDE_TEXT, 28u,
              "Model of the distortion: \"plumb_bob\", \"rational_polynomial\" or \"equidistant\".", "", NULL),
    JDE_FIELD("d", offsetof(jde_camera_info, d.items), offsetof(jde_camera_info, d.length), JDE_F64, JDE_SEQUENCE, 14u,
              "Coefficients of the distortion, in the order of OpenCV: k1, k2, p1, p2, k3, ...", "", NULL),
    JDE_FIELD("k", offsetof(jde_camera_info, k), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Intrinsic matrix of the raw picture, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1. An fx of 0: uncalibrated.", "", NULL),
    JDE_FIELD("r", offsetof(jde_camera_info, r), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Rectification, row by row: the rotation to the frame of the rectified picture.", "", NULL),
    JDE_FIELD("p", offsetof(jde_camera_info, p), 0u, JDE_F64, JDE_ARRAY, 12u,
              "Projection to the rectified picture, three rows of four: fx', 0, cx', Tx, 0, fy', cy', Ty, 0, 0, 1, 0.", "", NULL),
    JDE_FIELD("binning_x", offsetof(jde_camera_info, binning_x), 0u, JDE_U32, JDE_ONE, 1u,
              "Columns of the camera in a column of the picture; 0 and 1 are the same.", "", NULL),
    JDE_FIELD("binning_y", offsetof(jde_camera_info, binning_y), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows of the camera in a row of the picture; 0 and 1 are the same.", "", NULL),
    JDE_FIELD("roi", offsetof(jde_camera_info, roi), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The part of the camera's pixels that the picture shows, before binning.", "", &jde_region_of_interest_type),
    JDE_FIELD("_", offsetof(jde_camera_info, padding_492), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
};
static const jde_type jde_camera_info_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_camera_info_fields), "sensor_msgs/msg/CameraInfo", "The calibration of a camera, as ROS has it beside its pictures (REP-104). The middle of the first pixel is at\n0, 0.",
    sizeof(jde_camera_info), 8u, jde_camera_info_fields};

/** sensor_msgs/msg/PointField: What a point of a cloud has, and where. */
typedef struct jde_point_field {
    /** Name: "x", "y" and "z" are the position, m. */
    struct { uint32_t length; char bytes[28]; } name;
    /** Bytes from the start of the point. */
    uint32_t offset;
    /** 1 and 2 for int8 and uint8, 3 and 4 of 16 bits, 5 and 6 of 32 bits, 7 float32, 8 float64. */
    uint8_t datatype;
    uint8_t padding_37[3];
    /** Number of elements; 0 counts as 1. */
    uint32_t count;
} jde_point_field;

typedef char jde_point_field_has_its_size[sizeof(jde_point_field) == 44 ? 1 : -1];

static const jde_field jde_point_field_fields[] = {
    JDE_FIELD("name", offsetof(jde_point_field, name.bytes), offsetof(jde_point_field, name.length), JDE_U8, JDE_TEXT, 28u,
              "Name: \"x\", \"y\" and \"z\" are the position, m.", "", NULL),
    JDE_FIELD("offset", offsetof(jde_point_field, offset), 0u, JDE_U32, JDE_ONE, 1u,
              "Bytes from the start of the point.", "", NULL),
    JDE_FIELD("datatype", offsetof(jde_point_field, datatype), 0u, JDE_U8, JDE_ONE, 1u,
              "1 and 2 for int8 and uint8, 3 and 4 of 16 bits, 5 and 6 of 32 bits, 7 float32, 8 float64.", "", NULL),
    JDE_FIELD("_", offsetof(jde_point_field, padding_37), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("count", offsetof(jde_point_field, count), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of elements; 0 counts as 1.", "", NULL),
};
static const jde_type jde_point_field_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_point_field_fields), "sensor_msgs/msg/PointField", "What a point of a cloud has, and where.",
    sizeof(jde_point_field), 4u, jde_point_field_fields};

/**
 * sensor_msgs/msg/PointCloud2: A cloud of points, of up to 9 830 400 bytes: 640 × 480 points of 32 bytes. Bytes that a cloud does not have cost no
 * memory. A stack has no room for this type: fill a loan, or memory of the heap.
 */
typedef struct jde_point_cloud2 {
    /** Time, and the frame of the points. */
    jde_header header;
    /** Rows; 1 without an order. */
    uint32_t height;
    /** Points of a row. */
    uint32_t width;
    /** What each point has. */
    struct { uint32_t length; uint32_t spare; jde_point_field items[32]; } fields;
    /** Whether numbers begin with the most significant byte. */
    uint8_t is_bigendian;
    uint8_t padding_1489[3];
    /** Size of a point in bytes. */
    uint32_t point_step;
    /** Size of a row in bytes. */
    uint32_t row_step;
    /** The points, row by row. */
    struct { uint32_t length; uint32_t spare; uint8_t items[9830400]; } data;
    /** Whether all points are valid. */
    uint8_t is_dense;
    uint8_t padding_9831909[3];
} jde_point_cloud2;

typedef char jde_point_cloud2_has_its_size[sizeof(jde_point_cloud2) == 9831912 ? 1 : -1];

static const jde_field jde_point_cloud2_fields[] = {
    JDE_FIELD("header", offsetof(jde_point_cloud2, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the points.", "", &jde_header_type),
    JDE_FIELD("height", offsetof(jde_point_cloud2, height), 0u, JDE_U32, JDE_ONE, 1u,
              "Rows; 1 without an order.", "", NULL),
    JDE_FIELD("width", offsetof(jde_point_cloud2, width), 0u, JDE_U32, JDE_ONE, 1u,
              "Points of a row.", "", NULL),
    JDE_FIELD("fields", offsetof(jde_point_cloud2, fields.items), offsetof(jde_point_cloud2, fields.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "What each point has.", "", &jde_point_field_type),
    JDE_FIELD("is_bigendian", offsetof(jde_point_cloud2, is_bigendian), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether numbers begin with the most significant byte.", "", NULL),
    JDE_FIELD("_", offsetof(jde_point_cloud2, padding_1489), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("point_step", offsetof(jde_point_cloud2, point_step), 0u, JDE_U32, JDE_ONE, 1u,
              "Size of a point in bytes.", "", NULL),
    JDE_FIELD("row_step", offsetof(jde_point_cloud2, row_step), 0u, JDE_U32, JDE_ONE, 1u,
              "Size of a row in bytes.", "", NULL),
    JDE_FIELD("data", offsetof(jde_point_cloud2, data.items), offsetof(jde_point_cloud2, data.length), JDE_U8, JDE_SEQUENCE, 9830400u,
              "The points, row by row.", "", NULL),
    JDE_FIELD("is_dense", offsetof(jde_point_cloud2, is_dense), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether all points are valid.", "", NULL),
    JDE_FIELD("_", offsetof(jde_point_cloud2, padding_9831909), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
};
static const jde_type jde_point_cloud2_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_point_cloud2_fields), "sensor_msgs/msg/PointCloud2", "A cloud of points, of up to 9 830 400 bytes: 640 × 480 points of 32 bytes. Bytes that a cloud does not have cost no\nmemory. A stack has no room for this type: fill a loan, or memory of the heap.",
    sizeof(jde_point_cloud2), 4u, jde_point_cloud2_fields};

/** jde_msgs/msg/PanTilt: Direction of a pan-tilt head. ROS has a joint state with joint names instead; two named angles need none. */
typedef struct jde_pan_tilt {
    /** Time, and the frame of the head's base. */
    jde_header header;
    /** Angle to the left. [rad] */
    double pan;
    /** Angle downwards: a rotation about the axis to the left (REP-103). [rad] */
    double tilt;
    /** Angular velocity to the left. [rad/s] */
    double pan_velocity;
    /** Angular velocity downwards. [rad/s] */
    double tilt_velocity;
} jde_pan_tilt;

typedef char jde_pan_tilt_has_its_size[sizeof(jde_pan_tilt) == 96 ? 1 : -1];

static const jde_field jde_pan_tilt_fields[] = {
    JDE_FIELD("header", offsetof(jde_pan_tilt, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the head's base.", "", &jde_header_type),
    JDE_FIELD("pan", offsetof(jde_pan_tilt, pan), 0u, JDE_F64, JDE_ONE, 1u,
              "Angle to the left.", "rad", NULL),
    JDE_FIELD("tilt", offsetof(jde_pan_tilt, tilt), 0u, JDE_F64, JDE_ONE, 1u,
              "Angle downwards: a rotation about the axis to the left (REP-103).", "rad", NULL),
    JDE_FIELD("pan_velocity", offsetof(jde_pan_tilt, pan_velocity), 0u, JDE_F64, JDE_ONE, 1u,
              "Angular velocity to the left.", "rad/s", NULL),
    JDE_FIELD("tilt_velocity", offsetof(jde_pan_tilt, tilt_velocity), 0u, JDE_F64, JDE_ONE, 1u,
              "Angular velocity downwards.", "rad/s", NULL),
};
static const jde_type jde_pan_tilt_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_pan_tilt_fields), "jde_msgs/msg/PanTilt", "Direction of a pan-tilt head. ROS has a joint state with joint names instead; two named angles need none.",
    sizeof(jde_pan_tilt), 8u, jde_pan_tilt_fields};

/** jde_msgs/msg/ColorBlob: Connected pixels of one colour. */
typedef struct jde_color_blob {
    /** The number of its colour, from 0 in the order of the schema's ranges. */
    uint32_t color;
    /** Number of pixels. [px] */
    uint32_t count;
    /** First column of the rectangle around it. [px] */
    uint16_t left;
    /** First row of the rectangle around it. [px] */
    uint16_t top;
    /** Columns of the rectangle around it. [px] */
    uint16_t width;
    /** Rows of the rectangle around it. [px] */
    uint16_t height;
    /** Column of its middle, from the left edge of the picture. [px] */
    float column;
    /** Row of its middle, from the upper edge of the picture. [px] */
    float row;
    /** Angle to its middle, positive to the left. [rad] */
    double bearing;
    /** Angle to its middle above the horizon. [rad] */
    double elevation;
    /** Where its lowest row meets the floor, ahead of the base; 0 if that is unknown. [m] */
    double x;
    /** Where its lowest row meets the floor, to the left of the base; 0 if that is unknown. [m] */
    double y;
    /**
     * Whether x and y are known: the camera's height is, and its lowest row is below the horizon and in the
     * picture.
     */
    uint8_t on_floor;
    uint8_t padding_57[7];
} jde_color_blob;

typedef char jde_color_blob_has_its_size[sizeof(jde_color_blob) == 64 ? 1 : -1];

static const jde_field jde_color_blob_fields[] = {
    JDE_FIELD("color", offsetof(jde_color_blob, color), 0u, JDE_U32, JDE_ONE, 1u,
              "The number of its colour, from 0 in the order of the schema's ranges.", "", NULL),
    JDE_FIELD("count", offsetof(jde_color_blob, count), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of pixels.", "px", NULL),
    JDE_FIELD("left", offsetof(jde_color_blob, left), 0u, JDE_U16, JDE_ONE, 1u,
              "First column of the rectangle around it.", "px", NULL),
    JDE_FIELD("top", offsetof(jde_color_blob, top), 0u, JDE_U16, JDE_ONE, 1u,
              "First row of the rectangle around it.", "px", NULL),
    JDE_FIELD("width", offsetof(jde_color_blob, width), 0u, JDE_U16, JDE_ONE, 1u,
              "Columns of the rectangle around it.", "px", NULL),
    JDE_FIELD("height", offsetof(jde_color_blob, height), 0u, JDE_U16, JDE_ONE, 1u,
              "Rows of the rectangle around it.", "px", NULL),
    JDE_FIELD("column", offsetof(jde_color_blob, column), 0u, JDE_F32, JDE_ONE, 1u,
              "Column of its middle, from the left edge of the picture.", "px", NULL),
    JDE_FIELD("row", offsetof(jde_color_blob, row), 0u, JDE_F32, JDE_ONE, 1u,
              "Row of its middle, from the upper edge of the picture.", "px", NULL),
    JDE_FIELD("bearing", offsetof(jde_color_blob, bearing), 0u, JDE_F64, JDE_ONE, 1u,
              "Angle to its middle, positive to the left.", "rad", NULL),
    JDE_FIELD("elevation", offsetof(jde_color_blob, elevation), 0u, JDE_F64, JDE_ONE, 1u,
              "Angle to its middle above the horizon.", "rad", NULL),
    JDE_FIELD("x", offsetof(jde_color_blob, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Where its lowest row meets the floor, ahead of the base; 0 if that is unknown.", "m", NULL),
    JDE_FIELD("y", offsetof(jde_color_blob, y), 0u, JDE_F64, JDE_ONE, 1u,
              "Where its lowest row meets the floor, to the left of the base; 0 if that is unknown.", "m", NULL),
    JDE_FIELD("on_floor", offsetof(jde_color_blob, on_floor), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether x and y are known: the camera's height is, and its lowest row is below the horizon and in the\npicture.", "", NULL),
    JDE_FIELD("_", offsetof(jde_color_blob, padding_57), 0u, JDE_U8, JDE_PADDING, 7u, "", "", NULL),
};
static const jde_type jde_color_blob_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_color_blob_fields), "jde_msgs/msg/ColorBlob", "Connected pixels of one colour.",
    sizeof(jde_color_blob), 8u, jde_color_blob_fields};

/** jde_msgs/msg/ColorBlobs: The connected areas of some colours in a picture, the largest first. */
typedef struct jde_color_blobs {
    /** Time at which the picture was taken, and the frame of the angles. */
    jde_header header;
    /** Number of areas that did not fit below. */
    uint32_t left_out;
    uint8_t padding_68[4];
    /** The areas. */
    struct { uint32_t length; uint32_t spare; jde_color_blob items[32]; } blobs;
} jde_color_blobs;

typedef char jde_color_blobs_has_its_size[sizeof(jde_color_blobs) == 2128 ? 1 : -1];

static const jde_field jde_color_blobs_fields[] = {
    JDE_FIELD("header", offsetof(jde_color_blobs, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time at which the picture was taken, and the frame of the angles.", "", &jde_header_type),
    JDE_FIELD("left_out", offsetof(jde_color_blobs, left_out), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of areas that did not fit below.", "", NULL),
    JDE_FIELD("_", offsetof(jde_color_blobs, padding_68), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("blobs", offsetof(jde_color_blobs, blobs.items), offsetof(jde_color_blobs, blobs.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "The areas.", "", &jde_color_blob_type),
};
static const jde_type jde_color_blobs_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_color_blobs_fields), "jde_msgs/msg/ColorBlobs", "The connected areas of some colours in a picture, the largest first.",
    sizeof(jde_color_blobs), 8u, jde_color_blobs_fields};

/** jde_msgs/msg/TagDetection: A tag in a picture. */
typedef struct jde_tag_detection {
    /** The family, as "tag36h11". */
    struct { uint32_t length; char bytes[28]; } family;
    /** The number of the tag in its family. */
    uint32_t id;
    /** Bits that were read wrongly. */
    uint32_t hamming;
    /** How clearly black and white cells differ, from 0 up to about 250. False tags have small margins. */
    double margin;
    /**
     * Column and row of the lower left corner of its black border, then of the lower right, the upper right and
     * the upper left one, as one who reads the tag sees it, from the upper left corner of the picture. [px]
     */
    double corners[8];
    /**
     * Its pose in the frame of the camera. The origin of its own frame is its middle, x points to the right and
     * y down as one who reads the tag sees it, z into the tag.
     */
    jde_pose pose;
    /** The mean distance between the corners and where the pose puts them. [px] */
    double error;
    /**
     * `error` as a share of that of the other pose under which the tag looks nearly the same, 0 to 1: close to 1,
     * either of both may be the true one.
     */
    double ambiguity;
} jde_tag_detection;

typedef char jde_tag_detection_has_its_size[sizeof(jde_tag_detection) == 184 ? 1 : -1];

static const jde_field jde_tag_detection_fields[] = {
    JDE_FIELD("family", offsetof(jde_tag_detection, family.bytes), offsetof(jde_tag_detection, family.length), JDE_U8, JDE_TEXT, 28u,
              "The family, as \"tag36h11\".", "", NULL),
    JDE_FIELD("id", offsetof(jde_tag_detection, id), 0u, JDE_U32, JDE_ONE, 1u,
              "The number of the tag in its family.", "", NULL),
    JDE_FIELD("hamming", offsetof(jde_tag_detection, hamming), 0u, JDE_U32, JDE_ONE, 1u,
              "Bits that were read wrongly.", "", NULL),
    JDE_FIELD("margin", offsetof(jde_tag_detection, margin), 0u, JDE_F64, JDE_ONE, 1u,
              "How clearly black and white cells differ, from 0 up to about 250. False tags have small margins.", "", NULL),
    JDE_FIELD("corners", offsetof(jde_tag_detection, corners), 0u, JDE_F64, JDE_ARRAY, 8u,
              "Column and row of the lower left corner of its black border, then of the lower right, the upper right and\nthe upper left one, as one who reads the tag sees it, from the upper left corner of the picture.", "px", NULL),
    JDE_FIELD("pose", offsetof(jde_tag_detection, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Its pose in the frame of the camera. The origin of its own frame is its middle, x points to the right and\ny down as one who reads the tag sees it, z into the tag.", "", &jde_pose_type),
    JDE_FIELD("error", offsetof(jde_tag_detection, error), 0u, JDE_F64, JDE_ONE, 1u,
              "The mean distance between the corners and where the pose puts them.", "px", NULL),
    JDE_FIELD("ambiguity", offsetof(jde_tag_detection, ambiguity), 0u, JDE_F64, JDE_ONE, 1u,
              "`error` as a share of that of the other pose under which the tag looks nearly the same, 0 to 1: close to 1,\neither of both may be the true one.", "", NULL),
};
static const jde_type jde_tag_detection_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_tag_detection_fields), "jde_msgs/msg/TagDetection", "A tag in a picture.",
    sizeof(jde_tag_detection), 8u, jde_tag_detection_fields};

/** jde_msgs/msg/TagDetections: The tags in a picture, by family and number. */
typedef struct jde_tag_detections {
    /** Time at which the picture was taken, and the frame of the camera. */
    jde_header header;
    /** Number of tags that did not fit below. */
    uint32_t left_out;
    uint8_t padding_68[4];
    /** The tags. */
    struct { uint32_t length; uint32_t spare; jde_tag_detection items[32]; } tags;
} jde_tag_detections;

typedef char jde_tag_detections_has_its_size[sizeof(jde_tag_detections) == 5968 ? 1 : -1];

static const jde_field jde_tag_detections_fields[] = {
    JDE_FIELD("header", offsetof(jde_tag_detections, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time at which the picture was taken, and the frame of the camera.", "", &jde_header_type),
    JDE_FIELD("left_out", offsetof(jde_tag_detections, left_out), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of tags that did not fit below.", "", NULL),
    JDE_FIELD("_", offsetof(jde_tag_detections, padding_68), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("tags", offsetof(jde_tag_detections, tags.items), offsetof(jde_tag_detections, tags.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "The tags.", "", &jde_tag_detection_type),
};
static const jde_type jde_tag_detections_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_tag_detections_fields), "jde_msgs/msg/TagDetections", "The tags in a picture, by family and number.",
    sizeof(jde_tag_detections), 8u, jde_tag_detections_fields};

/** jde_msgs/msg/Person: A person. */
typedef struct jde_person {
    /** The number of the person, from 1, as long as the schema is awake. */
    uint32_t id;
    uint8_t padding_4[4];
    /** The position. */
    jde_point2d position;
    /** The velocity along x and y. [m/s] */
    double velocity[2];
    /** Standard deviation of the position along each axis. [m] */
    double deviation;
    /** How probable it is that this is a person, 0 to 1. */
    double confidence;
    /** How long the person has not been seen. [s] */
    double unseen;
} jde_person;

typedef char jde_person_has_its_size[sizeof(jde_person) == 64 ? 1 : -1];

static const jde_field jde_person_fields[] = {
    JDE_FIELD("id", offsetof(jde_person, id), 0u, JDE_U32, JDE_ONE, 1u,
              "The number of the person, from 1, as long as the schema is awake.", "", NULL),
    JDE_FIELD("_", offsetof(jde_person, padding_4), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("position", offsetof(jde_person, position), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The position.", "", &jde_point2d_type),
    JDE_FIELD("velocity", offsetof(jde_person, velocity), 0u, JDE_F64, JDE_ARRAY, 2u,
              "The velocity along x and y.", "m/s", NULL),
    JDE_FIELD("deviation", offsetof(jde_person, deviation), 0u, JDE_F64, JDE_ONE, 1u,
              "Standard deviation of the position along each axis.", "m", NULL),
    JDE_FIELD("confidence", offsetof(jde_person, confidence), 0u, JDE_F64, JDE_ONE, 1u,
              "How probable it is that this is a person, 0 to 1.", "", NULL),
    JDE_FIELD("unseen", offsetof(jde_person, unseen), 0u, JDE_F64, JDE_ONE, 1u,
              "How long the person has not been seen.", "s", NULL),
};
static const jde_type jde_person_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_person_fields), "jde_msgs/msg/Person", "A person.",
    sizeof(jde_person), 8u, jde_person_fields};

/** jde_msgs/msg/Persons: The persons around a robot. */
typedef struct jde_persons {
    /** Time of the scan, and the frame of the positions. */
    jde_header header;
    /** The persons. */
    struct { uint32_t length; uint32_t spare; jde_person items[32]; } persons;
} jde_persons;

typedef char jde_persons_has_its_size[sizeof(jde_persons) == 2120 ? 1 : -1];

static const jde_field jde_persons_fields[] = {
    JDE_FIELD("header", offsetof(jde_persons, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time of the scan, and the frame of the positions.", "", &jde_header_type),
    JDE_FIELD("persons", offsetof(jde_persons, persons.items), offsetof(jde_persons, persons.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "The persons.", "", &jde_person_type),
};
static const jde_type jde_persons_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_persons_fields), "jde_msgs/msg/Persons", "The persons around a robot.",
    sizeof(jde_persons), 8u, jde_persons_fields};

/** sensor_msgs/msg/BatteryState: State of the battery. NaN marks what is not measured. */
typedef struct jde_battery_state {
    /** Time. */
    jde_header header;
    /** Voltage. [V] */
    float voltage;
    /** Temperature. [degC] */
    float temperature;
    /** Current; negative while discharging. [A] */
    float current;
    /** Present charge. [Ah] */
    float charge;
    /** Charge when it was last full. [Ah] */
    float capacity;
    /** Nominal charge. [Ah] */
    float design_capacity;
    /** Charge, from 0 to 1. */
    float percentage;
    /** 0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full. */
    uint8_t power_supply_status;
    /** 0 unknown, 1 good, 2 too hot, 3 dead, 4 overvoltage, 5 failure, 6 too cold, 7 and 8 a timer expired. */
    uint8_t power_supply_health;
    /** 0 unknown, 1 NiMH, 2 Li-ion, 3 Li-polymer, 4 LiFe, 5 NiCd, 6 LiMn. */
    uint8_t power_supply_technology;
    /** Whether a battery is present. */
    uint8_t present;
    /** Voltage of each cell. [V] */
    struct { uint32_t length; uint32_t spare; float items[16]; } cell_voltage;
    /** Temperature of each cell. [degC] */
    struct { uint32_t length; uint32_t spare; float items[16]; } cell_temperature;
    /** Location of the battery. */
    struct { uint32_t length; char bytes[28]; } location;
    /** Its serial number. */
    struct { uint32_t length; char bytes[28]; } serial_number;
} jde_battery_state;

typedef char jde_battery_state_has_its_size[sizeof(jde_battery_state) == 304 ? 1 : -1];

static const jde_field jde_battery_state_fields[] = {
    JDE_FIELD("header", offsetof(jde_battery_state, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time.", "", &jde_header_type),
    JDE_FIELD("voltage", offsetof(jde_battery_state, voltage), 0u, JDE_F32, JDE_ONE, 1u,
              "Voltage.", "V", NULL),
    JDE_FIELD("temperature", offsetof(jde_battery_state, temperature), 0u, JDE_F32, JDE_ONE, 1u,
              "Temperature.", "degC", NULL),
    JDE_FIELD("current", offsetof(jde_battery_state, current), 0u, JDE_F32, JDE_ONE, 1u,
              "Current; negative while discharging.", "A", NULL),
    JDE_FIELD("charge", offsetof(jde_battery_state, charge), 0u, JDE_F32, JDE_ONE, 1u,
              "Present charge.", "Ah", NULL),
    JDE_FIELD("capacity", offsetof(jde_battery_state, capacity), 0u, JDE_F32, JDE_ONE, 1u,
              "Charge when it was last full.", "Ah", NULL),
    JDE_FIELD("design_capacity", offsetof(jde_battery_state, design_capacity), 0u, JDE_F32, JDE_ONE, 1u,
              "Nominal charge.", "Ah", NULL),
    JDE_FIELD("percentage", offsetof(jde_battery_state, percentage), 0u, JDE_F32, JDE_ONE, 1u,
              "Charge, from 0 to 1.", "", NULL),
    JDE_FIELD("power_supply_status", offsetof(jde_battery_state, power_supply_status), 0u, JDE_U8, JDE_ONE, 1u,
              "0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full.", "", NULL),
    JDE_FIELD("power_supply_health", offsetof(jde_battery_state, power_supply_health), 0u, JDE_U8, JDE_ONE, 1u,
              "0 unknown, 1 good, 2 too hot, 3 dead, 4 overvoltage, 5 failure, 6 too cold, 7 and 8 a timer expired.", "", NULL),
    JDE_FIELD("power_supply_technology", offsetof(jde_battery_state, power_supply_technology), 0u, JDE_U8, JDE_ONE, 1u,
              "0 unknown, 1 NiMH, 2 Li-ion, 3 Li-polymer, 4 LiFe, 5 NiCd, 6 LiMn.", "", NULL),
    JDE_FIELD("present", offsetof(jde_battery_state, present), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether a battery is present.", "", NULL),
    JDE_FIELD("cell_voltage", offsetof(jde_battery_state, cell_voltage.items), offsetof(jde_battery_state, cell_voltage.length), JDE_F32, JDE_SEQUENCE, 16u,
              "Voltage of each cell.", "V", NULL),
    JDE_FIELD("cell_temperature", offsetof(jde_battery_state, cell_temperature.items), offsetof(jde_battery_state, cell_temperature.length), JDE_F32, JDE_SEQUENCE, 16u,
              "Temperature of each cell.", "degC", NULL),
    JDE_FIELD("location", offsetof(jde_battery_state, location.bytes), offsetof(jde_battery_state, location.length), JDE_U8, JDE_TEXT, 28u,
              "Location of the battery.", "", NULL),
    JDE_FIELD("serial_number", offsetof(jde_battery_state, serial_number.bytes), offsetof(jde_battery_state, serial_number.length), JDE_U8, JDE_TEXT, 28u,
              "Its serial number.", "", NULL),
};
static const jde_type jde_battery_state_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_battery_state_fields), "sensor_msgs/msg/BatteryState", "State of the battery. NaN marks what is not measured.",
    sizeof(jde_battery_state), 4u, jde_battery_state_fields};

/** jde_msgs/msg/Bumpers: Which bumpers are pressed. */
typedef struct jde_bumpers {
    /** Time, and the frame of the base. */
    jde_header header;
    /** Front bumpers, from left to right. */
    struct { uint32_t length; uint32_t spare; uint8_t items[8]; } front;
    /** Rear bumpers, from left to right in the direction of travel. */
    struct { uint32_t length; uint32_t spare; uint8_t items[8]; } rear;
    /** Whether the wheels are blocked while driven. */
    uint8_t stalled;
    uint8_t padding_97[3];
} jde_bumpers;

typedef char jde_bumpers_has_its_size[sizeof(jde_bumpers) == 100 ? 1 : -1];

static const jde_field jde_bumpers_fields[] = {
    JDE_FIELD("header", offsetof(jde_bumpers, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the base.", "", &jde_header_type),
    JDE_FIELD("front", offsetof(jde_bumpers, front.items), offsetof(jde_bumpers, front.length), JDE_BOOL, JDE_SEQUENCE, 8u,
              "Front bumpers, from left to right.", "", NULL),
    JDE_FIELD("rear", offsetof(jde_bumpers, rear.items), offsetof(jde_bumpers, rear.length), JDE_BOOL, JDE_SEQUENCE, 8u,
              "Rear bumpers, from left to right in the direction of travel.", "", NULL),
    JDE_FIELD("stalled", offsetof(jde_bumpers, stalled), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether the wheels are blocked while driven.", "", NULL),
    JDE_FIELD("_", offsetof(jde_bumpers, padding_97), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
};
static const jde_type jde_bumpers_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_bumpers_fields), "jde_msgs/msg/Bumpers", "Which bumpers are pressed.",
    sizeof(jde_bumpers), 4u, jde_bumpers_fields};

/** jde_msgs/msg/LineSensor: The floor as a row of up to 32 reflectance cells sees it. */
typedef struct jde_line_sensor {
    /** Time, and the frame of the base. */
    jde_header header;
    /** Position of each cell, in the frame of the base. */
    struct { uint32_t length; uint32_t spare; jde_point2d items[32]; } cells;
    /** Brightness of the floor below each cell, from 0 (black) to 1 (white). */
    struct { uint32_t length; uint32_t spare; float items[32]; } brightness;
} jde_line_sensor;

typedef char jde_line_sensor_has_its_size[sizeof(jde_line_sensor) == 720 ? 1 : -1];

static const jde_field jde_line_sensor_fields[] = {
    JDE_FIELD("header", offsetof(jde_line_sensor, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the base.", "", &jde_header_type),
    JDE_FIELD("cells", offsetof(jde_line_sensor, cells.items), offsetof(jde_line_sensor, cells.length), JDE_STRUCT, JDE_SEQUENCE, 32u,
              "Position of each cell, in the frame of the base.", "", &jde_point2d_type),
    JDE_FIELD("brightness", offsetof(jde_line_sensor, brightness.items), offsetof(jde_line_sensor, brightness.length), JDE_F32, JDE_SEQUENCE, 32u,
              "Brightness of the floor below each cell, from 0 (black) to 1 (white).", "", NULL),
};
static const jde_type jde_line_sensor_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_line_sensor_fields), "jde_msgs/msg/LineSensor", "The floor as a row of up to 32 reflectance cells sees it.",
    sizeof(jde_line_sensor), 8u, jde_line_sensor_fields};

/** sensor_msgs/msg/Imu: Measurement of an inertial unit. Covariances are row by row; one of zeros is unknown. */
typedef struct jde_imu {
    /** Time, and the frame of the unit. */
    jde_header header;
    /** Orientation in a fixed frame with z up (REP-145). */
    jde_quaternion orientation;
    /** Covariance of the rotations about x, y and z, rad²; the first is −1 if there is no orientation. */
    double orientation_covariance[9];
    /** Turn rates about the unit's axes, rad/s. */
    jde_vector3 angular_velocity;
    /** Their covariance, (rad/s)². */
    double angular_velocity_covariance[9];
    /** Specific forces along the unit's axes, m/s²: at rest, the axis that is up shows 9.81 (REP-145). */
    jde_vector3 linear_acceleration;
    /** Their covariance, (m/s²)². */
    double linear_acceleration_covariance[9];
} jde_imu;

typedef char jde_imu_has_its_size[sizeof(jde_imu) == 360 ? 1 : -1];

static const jde_field jde_imu_fields[] = {
    JDE_FIELD("header", offsetof(jde_imu, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the unit.", "", &jde_header_type),
    JDE_FIELD("orientation", offsetof(jde_imu, orientation), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Orientation in a fixed frame with z up (REP-145).", "", &jde_quaternion_type),
    JDE_FIELD("orientation_covariance", offsetof(jde_imu, orientation_covariance), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Covariance of the rotations about x, y and z, rad²; the first is −1 if there is no orientation.", "", NULL),
    JDE_FIELD("angular_velocity", offsetof(jde_imu, angular_velocity), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Turn rates about the unit's axes, rad/s.", "", &jde_vector3_type),
    JDE_FIELD("angular_velocity_covariance", offsetof(jde_imu, angular_velocity_covariance), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Their covariance, (rad/s)².", "", NULL),
    JDE_FIELD("linear_acceleration", offsetof(jde_imu, linear_acceleration), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Specific forces along the unit's axes, m/s²: at rest, the axis that is up shows 9.81 (REP-145).", "", &jde_vector3_type),
    JDE_FIELD("linear_acceleration_covariance", offsetof(jde_imu, linear_acceleration_covariance), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Their covariance, (m/s²)².", "", NULL),
};
static const jde_type jde_imu_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_imu_fields), "sensor_msgs/msg/Imu", "Measurement of an inertial unit. Covariances are row by row; one of zeros is unknown.",
    sizeof(jde_imu), 8u, jde_imu_fields};

/** jde_msgs/msg/Name: A text in a list: a list of these is a `string[]` of ROS 2. */
typedef struct jde_name {
    /** The text. */
    struct { uint32_t length; char bytes[60]; } data;
} jde_name;

typedef char jde_name_has_its_size[sizeof(jde_name) == 64 ? 1 : -1];

static const jde_field jde_name_fields[] = {
    JDE_FIELD("data", offsetof(jde_name, data.bytes), offsetof(jde_name, data.length), JDE_U8, JDE_TEXT, 60u,
              "The text.", "", NULL),
};
static const jde_type jde_name_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_name_fields), "jde_msgs/msg/Name", "A text in a list: a list of these is a `string[]` of ROS 2.",
    sizeof(jde_name), 4u, jde_name_fields};

/** sensor_msgs/msg/JointState: The state of up to 64 joints. Each list has an element for each joint, in the order of the names, or is empty. */
typedef struct jde_joint_state {
    /** Time. */
    jde_header header;
    /** The names of the joints. */
    struct { uint32_t length; uint32_t spare; jde_name items[64]; } name;
    /** Angle, rad; of a joint that slides the distance, m. */
    struct { uint32_t length; uint32_t spare; double items[64]; } position;
    /** Velocity, rad/s or m/s. */
    struct { uint32_t length; uint32_t spare; double items[64]; } velocity;
    /** Torque, N·m, or force, N. */
    struct { uint32_t length; uint32_t spare; double items[64]; } effort;
} jde_joint_state;

typedef char jde_joint_state_has_its_size[sizeof(jde_joint_state) == 5728 ? 1 : -1];

static const jde_field jde_joint_state_fields[] = {
    JDE_FIELD("header", offsetof(jde_joint_state, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time.", "", &jde_header_type),
    JDE_FIELD("name", offsetof(jde_joint_state, name.items), offsetof(jde_joint_state, name.length), JDE_STRUCT, JDE_SEQUENCE, 64u,
              "The names of the joints.", "", &jde_name_type),
    JDE_FIELD("position", offsetof(jde_joint_state, position.items), offsetof(jde_joint_state, position.length), JDE_F64, JDE_SEQUENCE, 64u,
              "Angle, rad; of a joint that slides the distance, m.", "", NULL),
    JDE_FIELD("velocity", offsetof(jde_joint_state, velocity.items), offsetof(jde_joint_state, velocity.length), JDE_F64, JDE_SEQUENCE, 64u,
              "Velocity, rad/s or m/s.", "", NULL),
    JDE_FIELD("effort", offsetof(jde_joint_state, effort.items), offsetof(jde_joint_state, effort.length), JDE_F64, JDE_SEQUENCE, 64u,
              "Torque, N·m, or force, N.", "", NULL),
};
static const jde_type jde_joint_state_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_joint_state_fields), "sensor_msgs/msg/JointState", "The state of up to 64 joints. Each list has an element for each joint, in the order of the names, or is empty.",
    sizeof(jde_joint_state), 8u, jde_joint_state_fields};

/** sensor_msgs/msg/NavSatStatus: Whether a satellite receiver has a fix. */
typedef struct jde_nav_sat_status {
    /** -2 unknown, -1 no fix, 0 a fix, 1 one with corrections of satellites, 2 one with corrections of ground stations. */
    int8_t status;
    uint8_t padding_1[1];
    /** The systems in use, a sum: 1 GPS, 2 GLONASS, 4 BeiDou, 8 Galileo. */
    uint16_t service;
} jde_nav_sat_status;

typedef char jde_nav_sat_status_has_its_size[sizeof(jde_nav_sat_status) == 4 ? 1 : -1];

static const jde_field jde_nav_sat_status_fields[] = {
    JDE_FIELD("status", offsetof(jde_nav_sat_status, status), 0u, JDE_I8, JDE_ONE, 1u,
              "-2 unknown, -1 no fix, 0 a fix, 1 one with corrections of satellites, 2 one with corrections of ground stations.", "", NULL),
    JDE_FIELD("_", offsetof(jde_nav_sat_status, padding_1), 0u, JDE_U8, JDE_PADDING, 1u, "", "", NULL),
    JDE_FIELD("service", offsetof(jde_nav_sat_status, service), 0u, JDE_U16, JDE_ONE, 1u,
              "The systems in use, a sum: 1 GPS, 2 GLONASS, 4 BeiDou, 8 Galileo.", "", NULL),
};
static const jde_type jde_nav_sat_status_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_nav_sat_status_fields), "sensor_msgs/msg/NavSatStatus", "Whether a satellite receiver has a fix.",
    sizeof(jde_nav_sat_status), 2u, jde_nav_sat_status_fields};

/** sensor_msgs/msg/NavSatFix: A position on the Earth (WGS 84), as a satellite receiver measures it. */
typedef struct jde_nav_sat_fix {
    /** Time, and the frame of the antenna. */
    jde_header header;
    /** Whether there is a fix, and of which systems. */
    jde_nav_sat_status status;
    uint8_t padding_68[4];
    /** Latitude, positive to the north. [deg] */
    double latitude;
    /** Longitude, positive to the east. [deg] */
    double longitude;
    /** Height above the ellipsoid; NaN if it is unknown. [m] */
    double altitude;
    /** Covariance to the east, to the north and up, row by row. [m2] */
    double position_covariance[9];
    /** The covariance is 0 unknown, 1 estimated, 2 known on its diagonal, 3 known. */
    uint8_t position_covariance_type;
    uint8_t padding_169[7];
} jde_nav_sat_fix;

typedef char jde_nav_sat_fix_has_its_size[sizeof(jde_nav_sat_fix) == 176 ? 1 : -1];

static const jde_field jde_nav_sat_fix_fields[] = {
    JDE_FIELD("header", offsetof(jde_nav_sat_fix, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the antenna.", "", &jde_header_type),
    JDE_FIELD("status", offsetof(jde_nav_sat_fix, status), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Whether there is a fix, and of which systems.", "", &jde_nav_sat_status_type),
    JDE_FIELD("_", offsetof(jde_nav_sat_fix, padding_68), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("latitude", offsetof(jde_nav_sat_fix, latitude), 0u, JDE_F64, JDE_ONE, 1u,
              "Latitude, positive to the north.", "deg", NULL),
    JDE_FIELD("longitude", offsetof(jde_nav_sat_fix, longitude), 0u, JDE_F64, JDE_ONE, 1u,
              "Longitude, positive to the east.", "deg", NULL),
    JDE_FIELD("altitude", offsetof(jde_nav_sat_fix, altitude), 0u, JDE_F64, JDE_ONE, 1u,
              "Height above the ellipsoid; NaN if it is unknown.", "m", NULL),
    JDE_FIELD("position_covariance", offsetof(jde_nav_sat_fix, position_covariance), 0u, JDE_F64, JDE_ARRAY, 9u,
              "Covariance to the east, to the north and up, row by row.", "m2", NULL),
    JDE_FIELD("position_covariance_type", offsetof(jde_nav_sat_fix, position_covariance_type), 0u, JDE_U8, JDE_ONE, 1u,
              "The covariance is 0 unknown, 1 estimated, 2 known on its diagonal, 3 known.", "", NULL),
    JDE_FIELD("_", offsetof(jde_nav_sat_fix, padding_169), 0u, JDE_U8, JDE_PADDING, 7u, "", "", NULL),
};
static const jde_type jde_nav_sat_fix_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_nav_sat_fix_fields), "sensor_msgs/msg/NavSatFix", "A position on the Earth (WGS 84), as a satellite receiver measures it.",
    sizeof(jde_nav_sat_fix), 8u, jde_nav_sat_fix_fields};

/**
 * jde_msgs/msg/PositionFix: Measured position on the ground, as of a satellite receiver. ROS has latitude and longitude instead
 * (`sensor_msgs/msg/NavSatFix`); a robot that needs none of them is given metres. Without a fix there is no
 * value.
 */
typedef struct jde_position_fix {
    /** Time, and the fixed frame of the position. */
    jde_header header;
    /** Position of the antenna along x. [m] */
    double x;
    /** Position of the antenna along y. [m] */
    double y;
    /** Covariance of x and y, row by row. [m2] */
    double covariance[4];
} jde_position_fix;

typedef char jde_position_fix_has_its_size[sizeof(jde_position_fix) == 112 ? 1 : -1];

static const jde_field jde_position_fix_fields[] = {
    JDE_FIELD("header", offsetof(jde_position_fix, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the fixed frame of the position.", "", &jde_header_type),
    JDE_FIELD("x", offsetof(jde_position_fix, x), 0u, JDE_F64, JDE_ONE, 1u,
              "Position of the antenna along x.", "m", NULL),
    JDE_FIELD("y", offsetof(jde_position_fix, y), 0u, JDE_F64, JDE_ONE, 1u,
              "Position of the antenna along y.", "m", NULL),
    JDE_FIELD("covariance", offsetof(jde_position_fix, covariance), 0u, JDE_F64, JDE_ARRAY, 4u,
              "Covariance of x and y, row by row.", "m2", NULL),
};
static const jde_type jde_position_fix_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_position_fix_fields), "jde_msgs/msg/PositionFix", "Measured position on the ground, as of a satellite receiver. ROS has latitude and longitude instead\n(`sensor_msgs/msg/NavSatFix`); a robot that needs none of them is given metres. Without a fix there is no\nvalue.",
    sizeof(jde_position_fix), 8u, jde_position_fix_fields};

/** jde_msgs/msg/WheelEncoders: Counts of the two wheels' encoders since the driver's first reading. */
typedef struct jde_wheel_encoders {
    /** Time, and the frame of the base. */
    jde_header header;
    /** Ticks of the left wheel. Backward motion counts down; counts never wrap. */
    int64_t left;
    /** Ticks of the right wheel. */
    int64_t right;
    /** Ticks for one metre of rolling; 0 if unknown. [1/m] */
    double ticks_per_meter;
} jde_wheel_encoders;

typedef char jde_wheel_encoders_has_its_size[sizeof(jde_wheel_encoders) == 88 ? 1 : -1];

static const jde_field jde_wheel_encoders_fields[] = {
    JDE_FIELD("header", offsetof(jde_wheel_encoders, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the base.", "", &jde_header_type),
    JDE_FIELD("left", offsetof(jde_wheel_encoders, left), 0u, JDE_I64, JDE_ONE, 1u,
              "Ticks of the left wheel. Backward motion counts down; counts never wrap.", "", NULL),
    JDE_FIELD("right", offsetof(jde_wheel_encoders, right), 0u, JDE_I64, JDE_ONE, 1u,
              "Ticks of the right wheel.", "", NULL),
    JDE_FIELD("ticks_per_meter", offsetof(jde_wheel_encoders, ticks_per_meter), 0u, JDE_F64, JDE_ONE, 1u,
              "Ticks for one metre of rolling; 0 if unknown.", "1/m", NULL),
};
static const jde_type jde_wheel_encoders_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_wheel_encoders_fields), "jde_msgs/msg/WheelEncoders", "Counts of the two wheels' encoders since the driver's first reading.",
    sizeof(jde_wheel_encoders), 8u, jde_wheel_encoders_fields};

/** jde_msgs/msg/Connection: Connection of a driver to its device. */
typedef struct jde_connection {
    /** Time of the last change of state, or of the last failed attempt. */
    jde_header header;
    /** 0 not tried yet, 1 connecting, 2 connected, 3 lost. */
    uint8_t state;
    uint8_t padding_65[3];
    /** Attempts since the last connection. */
    uint32_t attempts;
    /** Name that the device reports, or why it is not connected. */
    struct { uint32_t length; char bytes[120]; } note;
} jde_connection;

typedef char jde_connection_has_its_size[sizeof(jde_connection) == 196 ? 1 : -1];

static const jde_field jde_connection_fields[] = {
    JDE_FIELD("header", offsetof(jde_connection, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time of the last change of state, or of the last failed attempt.", "", &jde_header_type),
    JDE_FIELD("state", offsetof(jde_connection, state), 0u, JDE_U8, JDE_ONE, 1u,
              "0 not tried yet, 1 connecting, 2 connected, 3 lost.", "", NULL),
    JDE_FIELD("_", offsetof(jde_connection, padding_65), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("attempts", offsetof(jde_connection, attempts), 0u, JDE_U32, JDE_ONE, 1u,
              "Attempts since the last connection.", "", NULL),
    JDE_FIELD("note", offsetof(jde_connection, note.bytes), offsetof(jde_connection, note.length), JDE_U8, JDE_TEXT, 120u,
              "Name that the device reports, or why it is not connected.", "", NULL),
};
static const jde_type jde_connection_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_connection_fields), "jde_msgs/msg/Connection", "Connection of a driver to its device.",
    sizeof(jde_connection), 4u, jde_connection_fields};

/** jde_msgs/msg/Mission: An application's task and its progress. */
typedef struct jde_mission {
    /** 0 running, 1 done, 2 failed. */
    uint8_t state;
    uint8_t padding_1[3];
    /** Number of targets reached. */
    uint32_t reached;
    /** Number of targets in total. */
    uint32_t total;
    /** Reason of a failure, or a description of the task. */
    struct { uint32_t length; char bytes[64]; } note;
    /** The present target, in the frame of the odometry. */
    jde_pose2d target;
    /** Distance to the present target. [m] */
    double distance;
} jde_mission;

typedef char jde_mission_has_its_size[sizeof(jde_mission) == 112 ? 1 : -1];

static const jde_field jde_mission_fields[] = {
    JDE_FIELD("state", offsetof(jde_mission, state), 0u, JDE_U8, JDE_ONE, 1u,
              "0 running, 1 done, 2 failed.", "", NULL),
    JDE_FIELD("_", offsetof(jde_mission, padding_1), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("reached", offsetof(jde_mission, reached), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of targets reached.", "", NULL),
    JDE_FIELD("total", offsetof(jde_mission, total), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of targets in total.", "", NULL),
    JDE_FIELD("note", offsetof(jde_mission, note.bytes), offsetof(jde_mission, note.length), JDE_U8, JDE_TEXT, 64u,
              "Reason of a failure, or a description of the task.", "", NULL),
    JDE_FIELD("target", offsetof(jde_mission, target), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "The present target, in the frame of the odometry.", "", &jde_pose2d_type),
    JDE_FIELD("distance", offsetof(jde_mission, distance), 0u, JDE_F64, JDE_ONE, 1u,
              "Distance to the present target.", "m", NULL),
};
static const jde_type jde_mission_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_mission_fields), "jde_msgs/msg/Mission", "An application's task and its progress.",
    sizeof(jde_mission), 8u, jde_mission_fields};

/** jde_msgs/msg/Truth: True state of a simulated robot, independent of its sensors; for measurement, not for control. */
typedef struct jde_truth {
    /** Pose in the world. */
    jde_pose2d pose;
    /** Velocity, in its own frame. */
    jde_twist twist;
    /** Distance from its edge to the nearest solid object. [m] */
    double clearance;
    /** Least clearance so far. [m] */
    double min_clearance;
    /** Contacts with solid objects, each counted once. */
    uint64_t collisions;
} jde_truth;

typedef char jde_truth_has_its_size[sizeof(jde_truth) == 96 ? 1 : -1];

static const jde_field jde_truth_fields[] = {
    JDE_FIELD("pose", offsetof(jde_truth, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Pose in the world.", "", &jde_pose2d_type),
    JDE_FIELD("twist", offsetof(jde_truth, twist), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Velocity, in its own frame.", "", &jde_twist_type),
    JDE_FIELD("clearance", offsetof(jde_truth, clearance), 0u, JDE_F64, JDE_ONE, 1u,
              "Distance from its edge to the nearest solid object.", "m", NULL),
    JDE_FIELD("min_clearance", offsetof(jde_truth, min_clearance), 0u, JDE_F64, JDE_ONE, 1u,
              "Least clearance so far.", "m", NULL),
    JDE_FIELD("collisions", offsetof(jde_truth, collisions), 0u, JDE_U64, JDE_ONE, 1u,
              "Contacts with solid objects, each counted once.", "", NULL),
};
static const jde_type jde_truth_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_truth_fields), "jde_msgs/msg/Truth", "True state of a simulated robot, independent of its sensors; for measurement, not for control.",
    sizeof(jde_truth), 8u, jde_truth_fields};

/** jde_msgs/msg/Thing: A static or moving object on the floor of a simulated world. */
typedef struct jde_thing {
    /** Its name in the world's file, cut if it is long. */
    struct { uint32_t length; char bytes[20]; } name;
    /** Center on the floor, and heading. */
    jde_pose2d pose;
    /** Size along its own x: length of a wall, diameter of a round object. [m] */
    float length;
    /** Size along its own y; 0 for a wall. [m] */
    float width;
    /** Height above the floor. [m] */
    float height;
    /** 0 a wall or a box, 1 a cylinder, 2 a ball, 3 a person, 4 a robot, 5 paint on the floor. */
    uint8_t form;
    /** Its color in sRGB. */
    uint8_t red;
    /** Its color in sRGB. */
    uint8_t green;
    /** Its color in sRGB. */
    uint8_t blue;
} jde_thing;

typedef char jde_thing_has_its_size[sizeof(jde_thing) == 64 ? 1 : -1];

static const jde_field jde_thing_fields[] = {
    JDE_FIELD("name", offsetof(jde_thing, name.bytes), offsetof(jde_thing, name.length), JDE_U8, JDE_TEXT, 20u,
              "Its name in the world's file, cut if it is long.", "", NULL),
    JDE_FIELD("pose", offsetof(jde_thing, pose), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Center on the floor, and heading.", "", &jde_pose2d_type),
    JDE_FIELD("length", offsetof(jde_thing, length), 0u, JDE_F32, JDE_ONE, 1u,
              "Size along its own x: length of a wall, diameter of a round object.", "m", NULL),
    JDE_FIELD("width", offsetof(jde_thing, width), 0u, JDE_F32, JDE_ONE, 1u,
              "Size along its own y; 0 for a wall.", "m", NULL),
    JDE_FIELD("height", offsetof(jde_thing, height), 0u, JDE_F32, JDE_ONE, 1u,
              "Height above the floor.", "m", NULL),
    JDE_FIELD("form", offsetof(jde_thing, form), 0u, JDE_U8, JDE_ONE, 1u,
              "0 a wall or a box, 1 a cylinder, 2 a ball, 3 a person, 4 a robot, 5 paint on the floor.", "", NULL),
    JDE_FIELD("red", offsetof(jde_thing, red), 0u, JDE_U8, JDE_ONE, 1u,
              "Its color in sRGB.", "", NULL),
    JDE_FIELD("green", offsetof(jde_thing, green), 0u, JDE_U8, JDE_ONE, 1u,
              "Its color in sRGB.", "", NULL),
    JDE_FIELD("blue", offsetof(jde_thing, blue), 0u, JDE_U8, JDE_ONE, 1u,
              "Its color in sRGB.", "", NULL),
};
static const jde_type jde_thing_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_thing_fields), "jde_msgs/msg/Thing", "A static or moving object on the floor of a simulated world.",
    sizeof(jde_thing), 8u, jde_thing_fields};

/** jde_msgs/msg/Scenery: The static objects of a simulated world. */
typedef struct jde_scenery {
    /** Time, and the frame of the world. */
    jde_header header;
    /** Number of objects that did not fit below. */
    uint32_t left_out;
    uint8_t padding_68[4];
    /** The objects. */
    struct { uint32_t length; uint32_t spare; jde_thing items[1024]; } things;
} jde_scenery;

typedef char jde_scenery_has_its_size[sizeof(jde_scenery) == 65616 ? 1 : -1];

static const jde_field jde_scenery_fields[] = {
    JDE_FIELD("header", offsetof(jde_scenery, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the world.", "", &jde_header_type),
    JDE_FIELD("left_out", offsetof(jde_scenery, left_out), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of objects that did not fit below.", "", NULL),
    JDE_FIELD("_", offsetof(jde_scenery, padding_68), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("things", offsetof(jde_scenery, things.items), offsetof(jde_scenery, things.length), JDE_STRUCT, JDE_SEQUENCE, 1024u,
              "The objects.", "", &jde_thing_type),
};
static const jde_type jde_scenery_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_scenery_fields), "jde_msgs/msg/Scenery", "The static objects of a simulated world.",
    sizeof(jde_scenery), 8u, jde_scenery_fields};

/** jde_msgs/msg/Movers: The moving and movable objects of a simulated world, without the robot that publishes them. */
typedef struct jde_movers {
    /** Time, and the frame of the world. */
    jde_header header;
    /** Number of objects that did not fit below. */
    uint32_t left_out;
    uint8_t padding_68[4];
    /** The objects. */
    struct { uint32_t length; uint32_t spare; jde_thing items[64]; } things;
} jde_movers;

typedef char jde_movers_has_its_size[sizeof(jde_movers) == 4176 ? 1 : -1];

static const jde_field jde_movers_fields[] = {
    JDE_FIELD("header", offsetof(jde_movers, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "Time, and the frame of the world.", "", &jde_header_type),
    JDE_FIELD("left_out", offsetof(jde_movers, left_out), 0u, JDE_U32, JDE_ONE, 1u,
              "Number of objects that did not fit below.", "", NULL),
    JDE_FIELD("_", offsetof(jde_movers, padding_68), 0u, JDE_U8, JDE_PADDING, 4u, "", "", NULL),
    JDE_FIELD("things", offsetof(jde_movers, things.items), offsetof(jde_movers, things.length), JDE_STRUCT, JDE_SEQUENCE, 64u,
              "The objects.", "", &jde_thing_type),
};
static const jde_type jde_movers_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_movers_fields), "jde_msgs/msg/Movers", "The moving and movable objects of a simulated world, without the robot that publishes them.",
    sizeof(jde_movers), 8u, jde_movers_fields};

/** std_srvs/srv/Empty_Request: A request without contents. */
typedef struct jde_empty_request {
    uint8_t padding_0[1];
} jde_empty_request;

typedef char jde_empty_request_has_its_size[sizeof(jde_empty_request) == 1 ? 1 : -1];

static const jde_field jde_empty_request_fields[] = {
    JDE_FIELD("_", offsetof(jde_empty_request, padding_0), 0u, JDE_U8, JDE_PADDING, 1u, "", "", NULL),
};
static const jde_type jde_empty_request_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_empty_request_fields), "std_srvs/srv/Empty_Request", "A request without contents.",
    sizeof(jde_empty_request), 1u, jde_empty_request_fields};

/** std_srvs/srv/Empty_Response: A response without contents. */
typedef struct jde_empty_response {
    uint8_t padding_0[1];
} jde_empty_response;

typedef char jde_empty_response_has_its_size[sizeof(jde_empty_response) == 1 ? 1 : -1];

static const jde_field jde_empty_response_fields[] = {
    JDE_FIELD("_", offsetof(jde_empty_response, padding_0), 0u, JDE_U8, JDE_PADDING, 1u, "", "", NULL),
};
static const jde_type jde_empty_response_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_empty_response_fields), "std_srvs/srv/Empty_Response", "A response without contents.",
    sizeof(jde_empty_response), 1u, jde_empty_response_fields};

/** std_srvs/srv/SetBool_Request: A request to switch something on or off. */
typedef struct jde_set_bool_request {
    /** On or off. */
    uint8_t data;
} jde_set_bool_request;

typedef char jde_set_bool_request_has_its_size[sizeof(jde_set_bool_request) == 1 ? 1 : -1];

static const jde_field jde_set_bool_request_fields[] = {
    JDE_FIELD("data", offsetof(jde_set_bool_request, data), 0u, JDE_BOOL, JDE_ONE, 1u,
              "On or off.", "", NULL),
};
static const jde_type jde_set_bool_request_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_set_bool_request_fields), "std_srvs/srv/SetBool_Request", "A request to switch something on or off.",
    sizeof(jde_set_bool_request), 1u, jde_set_bool_request_fields};

/** std_srvs/srv/SetBool_Response: What became of a request to switch something. */
typedef struct jde_set_bool_response {
    /** Whether it was done. */
    uint8_t success;
    uint8_t padding_1[3];
    /** What was done, or why it was not. */
    struct { uint32_t length; char bytes[252]; } message;
} jde_set_bool_response;

typedef char jde_set_bool_response_has_its_size[sizeof(jde_set_bool_response) == 260 ? 1 : -1];

static const jde_field jde_set_bool_response_fields[] = {
    JDE_FIELD("success", offsetof(jde_set_bool_response, success), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether it was done.", "", NULL),
    JDE_FIELD("_", offsetof(jde_set_bool_response, padding_1), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("message", offsetof(jde_set_bool_response, message.bytes), offsetof(jde_set_bool_response, message.length), JDE_U8, JDE_TEXT, 252u,
              "What was done, or why it was not.", "", NULL),
};
static const jde_type jde_set_bool_response_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_set_bool_response_fields), "std_srvs/srv/SetBool_Response", "What became of a request to switch something.",
    sizeof(jde_set_bool_response), 4u, jde_set_bool_response_fields};

/** std_srvs/srv/Trigger_Request: A request without contents, to do what the name of the service says. */
typedef struct jde_trigger_request {
    uint8_t padding_0[1];
} jde_trigger_request;

typedef char jde_trigger_request_has_its_size[sizeof(jde_trigger_request) == 1 ? 1 : -1];

static const jde_field jde_trigger_request_fields[] = {
    JDE_FIELD("_", offsetof(jde_trigger_request, padding_0), 0u, JDE_U8, JDE_PADDING, 1u, "", "", NULL),
};
static const jde_type jde_trigger_request_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_trigger_request_fields), "std_srvs/srv/Trigger_Request", "A request without contents, to do what the name of the service says.",
    sizeof(jde_trigger_request), 1u, jde_trigger_request_fields};

/** std_srvs/srv/Trigger_Response: What became of a request to do something. */
typedef struct jde_trigger_response {
    /** Whether it was done. */
    uint8_t success;
    uint8_t padding_1[3];
    /** What was done, or why it was not. */
    struct { uint32_t length; char bytes[252]; } message;
} jde_trigger_response;

typedef char jde_trigger_response_has_its_size[sizeof(jde_trigger_response) == 260 ? 1 : -1];

static const jde_field jde_trigger_response_fields[] = {
    JDE_FIELD("success", offsetof(jde_trigger_response, success), 0u, JDE_BOOL, JDE_ONE, 1u,
              "Whether it was done.", "", NULL),
    JDE_FIELD("_", offsetof(jde_trigger_response, padding_1), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("message", offsetof(jde_trigger_response, message.bytes), offsetof(jde_trigger_response, message.length), JDE_U8, JDE_TEXT, 252u,
              "What was done, or why it was not.", "", NULL),
};
static const jde_type jde_trigger_response_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(jde_trigger_response_fields), "std_srvs/srv/Trigger_Response", "What became of a request to do something.",
    sizeof(jde_trigger_response), 4u, jde_trigger_response_fields};

#ifdef __cplusplus
}
#endif

#endif
