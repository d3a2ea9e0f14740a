/*
 * Where a ball is, for plugins in C: the same as `Ball` of the crate jde-ball, field by field. A test compares the two.
 */
#ifndef BALL_H
#define BALL_H

#include "jde_types.h"

/** Where a ball is, as the robot sees it. */
typedef struct ball {
    /** When the picture was taken, and the frame of the angles. */
    jde_header header;
    /** Whether it is in the picture. */
    uint8_t seen;
    uint8_t padding[3];
    /** Pixels it has in the picture. */
    uint32_t count;
    /** For how long it has not been seen; since the first picture if it never was. [s] */
    double unseen;
    /** To the left. [rad] */
    double bearing;
    /** Up, from the horizon. [rad] */
    double elevation;
    /** From the camera to the middle of the ball; 0 until it has been seen. [m] */
    double distance;
    /** Column of its middle in the picture, from the left edge. [px] */
    double column;
    /** Row of its middle in the picture, from the upper edge. [px] */
    double row;
} ball;

static const jde_field ball_fields[] = {
    JDE_FIELD("header", offsetof(ball, header), 0u, JDE_STRUCT, JDE_ONE, 1u,
              "When the picture was taken, and the frame of the angles.", "", &jde_header_type),
    JDE_FIELD("seen", offsetof(ball, seen), 0u, JDE_BOOL, JDE_ONE, 1u, "Whether it is in the picture.", "", NULL),
    JDE_FIELD("_", offsetof(ball, padding), 0u, JDE_U8, JDE_PADDING, 3u, "", "", NULL),
    JDE_FIELD("count", offsetof(ball, count), 0u, JDE_U32, JDE_ONE, 1u, "Pixels it has in the picture.", "", NULL),
    JDE_FIELD("unseen", offsetof(ball, unseen), 0u, JDE_F64, JDE_ONE, 1u,
              "For how long it has not been seen; since the first picture if it never was.", "s", NULL),
    JDE_FIELD("bearing", offsetof(ball, bearing), 0u, JDE_F64, JDE_ONE, 1u, "To the left.", "rad", NULL),
    JDE_FIELD("elevation", offsetof(ball, elevation), 0u, JDE_F64, JDE_ONE, 1u, "Up, from the horizon.", "rad", NULL),
    JDE_FIELD("distance", offsetof(ball, distance), 0u, JDE_F64, JDE_ONE, 1u,
              "From the camera to the middle of the ball; 0 until it has been seen.", "m", NULL),
    JDE_FIELD("column", offsetof(ball, column), 0u, JDE_F64, JDE_ONE, 1u,
              "Column of its middle in the picture, from the left edge.", "px", NULL),
    JDE_FIELD("row", offsetof(ball, row), 0u, JDE_F64, JDE_ONE, 1u,
              "Row of its middle in the picture, from the upper edge.", "px", NULL),
};
static const jde_type ball_type = {
    (uint32_t)sizeof(jde_type), JDE_COUNT(ball_fields), "jde_msgs/msg/Ball", "Where a ball is, as the robot sees it.",
    sizeof(ball), 8u, ball_fields};

#endif
