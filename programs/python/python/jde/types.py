"""The standard types of sensors and actuators: SI units, axes of REP-103.

Generated from plugin/types; `cargo xtask headers` renews it.
"""

import math
from collections.abc import Sequence

from jde import _standard
from jde._standard import LaserPoint, SonarEcho, normalize_angle
from jde._values import field, standard

__all__ = [
    "BatteryState",
    "Body",
    "Bumpers",
    "CameraInfo",
    "Chunk",
    "ChunkStep",
    "ColorBlob",
    "ColorBlobs",
    "CompressedImage",
    "Connection",
    "Empty_Request",
    "Empty_Response",
    "Footprint",
    "Header",
    "Image",
    "Imu",
    "JointState",
    "Lanes",
    "LaserPoint",
    "LaserScan",
    "LineSensor",
    "MapMetaData",
    "Mission",
    "Mount",
    "Movers",
    "NavSatFix",
    "NavSatStatus",
    "OccupancyGrid",
    "Odometry",
    "PanTilt",
    "Path",
    "Person",
    "Persons",
    "Point",
    "Point2D",
    "PointCloud2",
    "PointField",
    "Pose",
    "Pose2D",
    "PoseStamped",
    "PoseWithCovariance",
    "PositionFix",
    "Quaternion",
    "Range",
    "RangeRing",
    "RegionOfInterest",
    "Route",
    "Scenery",
    "SetBool_Request",
    "SetBool_Response",
    "SonarEcho",
    "Start",
    "Strip",
    "TagDetection",
    "TagDetections",
    "Target",
    "Thing",
    "Time",
    "Transform",
    "TransformStamped",
    "Trigger_Request",
    "Trigger_Response",
    "Truth",
    "Twist",
    "TwistWithCovariance",
    "Vector3",
    "WheelEncoders",
    "Zone",
    "Zones",
    "normalize_angle",
]


@standard("builtin_interfaces/msg/Time")
class Time:
    """A time, in seconds and nanoseconds since the application's start."""

    sec: int = 0
    """Whole seconds. [s]"""

    nanosec: int = 0
    """Remaining nanoseconds, below 10^9. [ns]"""


@standard("std_msgs/msg/Header")
class Header:
    """Time and frame of a measurement."""

    stamp: Time = field(default_factory=Time)
    """Time of the measurement."""

    frame_id: str = ""
    """Frame of the coordinates."""


@standard("geometry_msgs/msg/Point")
class Point:
    """A point in space."""

    x: float = 0.0
    """Ahead. [m]"""

    y: float = 0.0
    """To the left. [m]"""

    z: float = 0.0
    """Up. [m]"""


@standard("geometry_msgs/msg/Vector3")
class Vector3:
    """A vector in space; its unit is that of the field that contains it."""

    x: float = 0.0
    """Component ahead, or about the axis ahead."""

    y: float = 0.0
    """Component to the left, or about the axis to the left."""

    z: float = 0.0
    """Component up, or about the axis up."""


@standard("geometry_msgs/msg/Quaternion")
class Quaternion(_standard.QuaternionFunctions):
    """An orientation in space, as a quaternion. Only its direction counts: `Quaternion::normalized` has length 1, and
    one of zeros is no orientation.
    """

    x: float = 0.0

    y: float = 0.0

    z: float = 0.0

    w: float = 1.0


@standard("geometry_msgs/msg/Pose")
class Pose:
    """A position and an orientation in space."""

    position: Point = field(default_factory=Point)
    """Position."""

    orientation: Quaternion = field(default_factory=Quaternion)
    """Orientation."""


@standard("geometry_msgs/msg/PoseStamped")
class PoseStamped:
    """A pose with its time and frame."""

    header: Header = field(default_factory=Header)
    """Time and frame."""

    pose: Pose = field(default_factory=Pose)
    """The pose."""


@standard("geometry_msgs/msg/PoseWithCovariance")
class PoseWithCovariance:
    """A pose with its covariance."""

    pose: Pose = field(default_factory=Pose)
    """The pose."""

    covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 36)
    """6 × 6, row by row, for x, y, z and the rotations about them."""


@standard("jde_msgs/msg/Point2D")
class Point2D:
    """A position in the plane."""

    x: float = 0.0
    """Ahead of the frame's origin. [m]"""

    y: float = 0.0
    """Left of the frame's origin. [m]"""


@standard("geometry_msgs/msg/Pose2D")
class Pose2D(_standard.Pose2DFunctions):
    """A position and a heading in the plane."""

    x: float = 0.0
    """Ahead of the frame's origin. [m]"""

    y: float = 0.0
    """Left of the frame's origin. [m]"""

    theta: float = 0.0
    """Heading, counter-clockwise from the x axis. [rad]"""


@standard("geometry_msgs/msg/Transform")
class Transform:
    """Translation and rotation of a frame in another one."""

    translation: Vector3 = field(default_factory=Vector3)
    """Position of the frame's origin. [m]"""

    rotation: Quaternion = field(default_factory=Quaternion)
    """Orientation of the frame."""


@standard("geometry_msgs/msg/TransformStamped")
class TransformStamped:
    """Where a frame is in another one at a time."""

    header: Header = field(default_factory=Header)
    """Time, and the frame in which the transform is stated."""

    child_frame_id: str = ""
    """The frame that is there."""

    transform: Transform = field(default_factory=Transform)
    """Where it is."""


@standard("geometry_msgs/msg/Twist")
class Twist(_standard.TwistFunctions):
    """A velocity in space, commanded or measured."""

    linear: Vector3 = field(default_factory=Vector3)
    """Linear velocity, m/s. [m/s]"""

    angular: Vector3 = field(default_factory=Vector3)
    """Angular velocity, rad/s. [rad/s]"""


@standard("geometry_msgs/msg/TwistWithCovariance")
class TwistWithCovariance:
    """A velocity with its covariance."""

    twist: Twist = field(default_factory=Twist)
    """The velocity."""

    covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 36)
    """6 × 6, row by row, for x, y, z and the rotations about them."""


@standard("jde_msgs/msg/Chunk")
class Chunk:
    """Future commands of a base, made of what was seen at one instant: the time of the value. It is no command. A
    motor schema that imports it gives each of its commands when it comes due.
    """

    spacing: float = 0.0
    """From one command to the next. The first is due at the time of the value; the last is meant for as long as the
    others. [s]
    """

    certainty: float = 0.0
    """How sure its maker is, from 0 (not at all) to 1."""

    blend: float = 0.0
    """The weight of each chunk in a blend, as a share of the weight of the chunk before it."""

    blended: int = 0
    """How many chunks before it its commands are blended with; 0 if it replaces them."""

    commands: Sequence[Twist] = field(default_factory=list)
    """The commands, in the order in which they come due."""


@standard("jde_msgs/msg/ChunkStep")
class ChunkStep:
    """A command of a chunk that came due."""

    chunk: int = 0
    """The number of the chunk among those of its maker."""

    age: float = 0.0
    """How long before this step it was seen what the chunk is made of. [s]"""

    step: int = 0
    """The place of the command in the chunk, from 1."""

    steps: int = 0
    """How many commands the chunk has."""

    blended: int = 0
    """How many chunks before it have a share in the command."""

    command: Twist = field(default_factory=Twist)
    """The command, as it was given: before limits and the judgement of guards."""


@standard("nav_msgs/msg/Odometry")
class Odometry(_standard.OdometryFunctions):
    """Pose and velocity, as measured by the wheels."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the pose: "odom"."""

    child_frame_id: str = ""
    """The frame of the velocity: "base_link"."""

    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    """Pose of the base, in the frame of the header."""

    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)
    """Velocity of the base, in its own frame."""


@standard("nav_msgs/msg/MapMetaData")
class MapMetaData:
    """Size, resolution and origin of a map."""

    map_load_time: Time = field(default_factory=Time)
    """Time at which the map was loaded."""

    resolution: float = 0.0
    """Side of a cell. [m]"""

    width: int = 0
    """Columns."""

    height: int = 0
    """Rows."""

    origin: Pose = field(default_factory=Pose)
    """Pose of the lower left corner of the first cell."""


@standard("nav_msgs/msg/OccupancyGrid")
class OccupancyGrid:
    """A map of up to 4096 × 4096 cells: 200 m at 5 cm. Cells that a map does not have cost no memory. A stack has no
    room for this type: fill a loan, or memory of the heap.
    """

    header: Header = field(default_factory=Header)
    """Time, and the frame of the origin."""

    info: MapMetaData = field(default_factory=MapMetaData)
    """Size, resolution and origin."""

    data: Sequence[int] = field(default_factory=list)
    """The cells, row by row from the origin: 0 to 100 is the probability of an obstacle in percent, -1 unknown."""


@standard("nav_msgs/msg/Path")
class Path:
    """A path to follow, of up to 256 poses: ways through a building turn more often than 64 times."""

    header: Header = field(default_factory=Header)
    """Time and frame."""

    poses: Sequence[PoseStamped] = field(default_factory=list)
    """The poses, from first to last."""


@standard("jde_msgs/msg/Route")
class Route:
    """Targets in the plane, in a form for files; ROS tools draw a `Path`."""

    poses: Sequence[Pose2D] = field(default_factory=list)
    """The targets, from first to last."""


@standard("jde_msgs/msg/Start")
class Start:
    """An optional pose at which a robot starts, in a form for files: `[[3.55, 1.6, "90 deg"]]`, or `[]` for none."""

    pose: Sequence[Pose2D] = field(default_factory=list)
    """The pose, in the frame of the world or of the map."""


@standard("jde_msgs/msg/Target")
class Target(_standard.TargetFunctions):
    """An optional target: a place, or a pose if its heading counts."""

    pose: Pose2D = field(default_factory=Pose2D)
    """The position and the heading, in the frame of the odometry."""

    set: bool = False
    """Whether there is a target."""

    has_heading: bool = False
    """Whether its heading counts. Otherwise the robot may face anywhere."""


@standard("jde_msgs/msg/Footprint")
class Footprint:
    """The outline of a robot on the floor: in files `{ radius = 0.25 }`, or `{ points = [[0.3, 0.2], ...] }`."""

    radius: float = 0.0
    """Radius of the circle around the origin of the base; not used if there are points. [m]"""

    points: Sequence[Point2D] = field(default_factory=list)
    """The corners of a convex polygon in the frame of the base, in order; none for a circle."""


@standard("jde_msgs/msg/Mount")
class Mount:
    """Where a sensor is on a robot."""

    frame: str = ""
    """The frame of the sensor, as in the headers of its values."""

    pose: Pose2D = field(default_factory=Pose2D)
    """Its pose in the frame of the base."""


@standard("jde_msgs/msg/Body")
class Body:
    """The body of a robot, for windows and pictures. A driver publishes it once it is known."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the base."""

    footprint: Footprint = field(default_factory=Footprint)
    """The outline; a circle of radius 0 if it is unknown."""

    lasers: Sequence[Mount] = field(default_factory=list)
    """Where its lasers are."""


@standard("jde_msgs/msg/Zone")
class Zone:
    """An area of the floor: a polygon, in files `{ corners = [[1, 1], [2, 1], [2, 2]] }`."""

    corners: Sequence[Point2D] = field(default_factory=list)
    """At least three corners, in order, in the frame of the map. The last is connected to the first."""


@standard("jde_msgs/msg/Zones")
class Zones:
    """Areas of the floor, of which up to 16 fit: in files `{ zones = [{ corners = [[1, 1], ...] }, ...] }`."""

    zones: Sequence[Zone] = field(default_factory=list)
    """The areas; they may overlap."""


@standard("jde_msgs/msg/Strip")
class Strip:
    """A strip of the floor: a line with a width, in files `{ width = 0.6, points = [[1, 1], [4, 1]] }`."""

    width: float = 0.0
    """The width. [m]"""

    points: Sequence[Point2D] = field(default_factory=list)
    """At least two points, in order, in the frame of the map."""


@standard("jde_msgs/msg/Lanes")
class Lanes:
    """Lanes, the strips that paths prefer, of which up to 16 fit: in files `{ lanes = [{ width = 0.6, points = [[1,
    1], ...] }, ...] }`.
    """

    lanes: Sequence[Strip] = field(default_factory=list)
    """The strips; they may cross and overlap."""


@standard("sensor_msgs/msg/LaserScan")
class LaserScan(_standard.LaserScanFunctions):
    """One scan of a laser scanner with up to 1088 beams."""

    header: Header = field(default_factory=Header)
    """Time of the first beam, and the frame of the scanner: x ahead, angles counter-clockwise about z."""

    angle_min: float = 0.0
    """Angle of the first beam. [rad]"""

    angle_max: float = 0.0
    """Angle of the last beam. [rad]"""

    angle_increment: float = 0.0
    """Angle from one beam to the next. [rad]"""

    time_increment: float = 0.0
    """Time from one beam to the next. [s]"""

    scan_time: float = 0.0
    """Time from one scan to the next. [s]"""

    range_min: float = 0.0
    """Least measurable distance. [m]"""

    range_max: float = 0.0
    """Greatest measurable distance. [m]"""

    ranges: Sequence[float] = field(default_factory=list)
    """Distances, in the order of the beams. [m]"""

    intensities: Sequence[float] = field(default_factory=list)
    """Intensities, in units of the device; empty if it has none."""


@standard("sensor_msgs/msg/Range")
class Range:
    """One sonar or infrared sensor."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the sensor: x ahead."""

    radiation_type: int = 0
    """0 ultrasound, 1 infrared."""

    field_of_view: float = 0.0
    """Angular width of the cone. [rad]"""

    min_range: float = 0.0
    """Least measurable distance. [m]"""

    max_range: float = 0.0
    """Greatest measurable distance. [m]"""

    range: float = 0.0
    """Measured distance. [m]"""

    variance: float = 0.0
    """Variance of the distance; 0 if unknown. [m2]"""


@standard("jde_msgs/msg/RangeRing")
class RangeRing(_standard.RangeRingFunctions):
    """A ring of up to 32 range sensors of one type around a base."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the base."""

    radiation_type: int = 0
    """0 ultrasound, 1 infrared."""

    field_of_view: float = 0.0
    """Angular width of each cone. [rad]"""

    min_range: float = 0.0
    """Least measurable distance. [m]"""

    max_range: float = 0.0
    """Greatest measurable distance. [m]"""

    poses: Sequence[Pose2D] = field(default_factory=list)
    """Position and direction of each sensor, in the frame of the base."""

    ranges: Sequence[float] = field(default_factory=list)
    """Measured distance of each sensor. [m]"""


@standard("sensor_msgs/msg/Image")
class Image(_standard.ImageFunctions):
    """An image of up to 640 × 480 pixels of three bytes, or 640 × 360 depths."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the camera: x to the right of the image, y down, z into it."""

    height: int = 0
    """Rows."""

    width: int = 0
    """Columns."""

    encoding: str = ""
    """Format of a pixel: "rgb8", "bgr8", "mono8"; "32FC1" for a depth in metres (REP-118)."""

    is_bigendian: int = 0
    """Whether numbers of several bytes begin with the most significant byte."""

    step: int = 0
    """Size of a row in bytes."""

    data: Sequence[int] = field(default_factory=list)
    """Rows, from top to bottom."""


@standard("sensor_msgs/msg/CompressedImage")
class CompressedImage:
    """A compressed image of up to 1 MiB. A stack has no room for this type: fill a loan, or memory of the heap."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the camera, as of an `Image`."""

    format: str = ""
    """Format: "jpeg" or "png", perhaps within more words, as in "rgb8; jpeg compressed bgr8"."""

    data: Sequence[int] = field(default_factory=list)
    """A file of that format."""


@standard("sensor_msgs/msg/RegionOfInterest")
class RegionOfInterest:
    """A rectangle of the pixels of a camera."""

    x_offset: int = 0
    """First column. [px]"""

    y_offset: int = 0
    """First row. [px]"""

    height: int = 0
    """Rows; 0 for all. [px]"""

    width: int = 0
    """Columns; 0 for all. [px]"""

    do_rectify: bool = False
    """Whether the rectangle is of the rectified picture."""


@standard("sensor_msgs/msg/CameraInfo")
class CameraInfo:
    """The calibration of a camera, as ROS has it beside its pictures (REP-104). The middle of the first pixel is at 0,
    0.
    """

    header: Header = field(default_factory=Header)
    """Time of the picture, and the frame of the camera."""

    height: int = 0
    """Rows of the pictures of the calibration. [px]"""

    width: int = 0
    """Columns of the pictures of the calibration. [px]"""

    distortion_model: str = ""
    """Model of the distortion: "plumb_bob", "rational_polynomial" or "equidistant"."""

    d: Sequence[float] = field(default_factory=list)
    """Coefficients of the distortion, in the order of OpenCV: k1, k2, p1, p2, k3, ..."""

    k: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Intrinsic matrix of the raw picture, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1. An fx of 0: uncalibrated."""

    r: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Rectification, row by row: the rotation to the frame of the rectified picture."""

    p: Sequence[float] = field(default_factory=lambda: [0.0] * 12)
    """Projection to the rectified picture, three rows of four: fx', 0, cx', Tx, 0, fy', cy', Ty, 0, 0, 1, 0."""

    binning_x: int = 0
    """Columns of the camera in a column of the picture; 0 and 1 are the same."""

    binning_y: int = 0
    """Rows of the camera in a row of the picture; 0 and 1 are the same."""

    roi: RegionOfInterest = field(default_factory=RegionOfInterest)
    """The part of the camera's pixels that the picture shows, before binning."""


@standard("sensor_msgs/msg/PointField")
class PointField:
    """What a point of a cloud has, and where."""

    name: str = ""
    """Name: "x", "y" and "z" are the position, m."""

    offset: int = 0
    """Bytes from the start of the point."""

    datatype: int = 0
    """1 and 2 for int8 and uint8, 3 and 4 of 16 bits, 5 and 6 of 32 bits, 7 float32, 8 float64."""

    count: int = 0
    """Number of elements; 0 counts as 1."""


@standard("sensor_msgs/msg/PointCloud2")
class PointCloud2:
    """A cloud of points, of up to 9 830 400 bytes: 640 × 480 points of 32 bytes. Bytes that a cloud does not have
    cost no memory. A stack has no room for this type: fill a loan, or memory of the heap.
    """

    header: Header = field(default_factory=Header)
    """Time, and the frame of the points."""

    height: int = 0
    """Rows; 1 without an order."""

    width: int = 0
    """Points of a row."""

    fields: Sequence[PointField] = field(default_factory=list)
    """What each point has."""

    is_bigendian: bool = False
    """Whether numbers begin with the most significant byte."""

    point_step: int = 0
    """Size of a point in bytes."""

    row_step: int = 0
    """Size of a row in bytes."""

    data: Sequence[int] = field(default_factory=list)
    """The points, row by row."""

    is_dense: bool = False
    """Whether all points are valid."""


@standard("jde_msgs/msg/PanTilt")
class PanTilt:
    """Direction of a pan-tilt head. ROS has a joint state with joint names instead; two named angles need none."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the head's base."""

    pan: float = 0.0
    """Angle to the left. [rad]"""

    tilt: float = 0.0
    """Angle downwards: a rotation about the axis to the left (REP-103). [rad]"""

    pan_velocity: float = 0.0
    """Angular velocity to the left. [rad/s]"""

    tilt_velocity: float = 0.0
    """Angular velocity downwards. [rad/s]"""


@standard("jde_msgs/msg/ColorBlob")
class ColorBlob:
    """Connected pixels of one colour."""

    color: int = 0
    """The number of its colour, from 0 in the order of the schema's ranges."""

    count: int = 0
    """Number of pixels. [px]"""

    left: int = 0
    """First column of the rectangle around it. [px]"""

    top: int = 0
    """First row of the rectangle around it. [px]"""

    width: int = 0
    """Columns of the rectangle around it. [px]"""

    height: int = 0
    """Rows of the rectangle around it. [px]"""

    column: float = 0.0
    """Column of its middle, from the left edge of the picture. [px]"""

    row: float = 0.0
    """Row of its middle, from the upper edge of the picture. [px]"""

    bearing: float = 0.0
    """Angle to its middle, positive to the left. [rad]"""

    elevation: float = 0.0
    """Angle to its middle above the horizon. [rad]"""

    x: float = 0.0
    """Where its lowest row meets the floor, ahead of the base; 0 if that is unknown. [m]"""

    y: float = 0.0
    """Where its lowest row meets the floor, to the left of the base; 0 if that is unknown. [m]"""

    on_floor: bool = False
    """Whether x and y are known: the camera's height is, and its lowest row is below the horizon and in the picture."""


@standard("jde_msgs/msg/ColorBlobs")
class ColorBlobs:
    """The connected areas of some colours in a picture, the largest first."""

    header: Header = field(default_factory=Header)
    """Time at which the picture was taken, and the frame of the angles."""

    left_out: int = 0
    """Number of areas that did not fit below."""

    blobs: Sequence[ColorBlob] = field(default_factory=list)
    """The areas."""


@standard("jde_msgs/msg/TagDetection")
class TagDetection:
    """A tag in a picture."""

    family: str = ""
    """The family, as "tag36h11"."""

    id: int = 0
    """The number of the tag in its family."""

    hamming: int = 0
    """Bits that were read wrongly."""

    margin: float = 0.0
    """How clearly black and white cells differ, from 0 up to about 250. False tags have small margins."""

    corners: Sequence[float] = field(default_factory=lambda: [0.0] * 8)
    """Column and row of the lower left corner of its black border, then of the lower right, the upper right and the
    upper left one, as one who reads the tag sees it, from the upper left corner of the picture. [px]
    """

    pose: Pose = field(default_factory=Pose)
    """Its pose in the frame of the camera. The origin of its own frame is its middle, x points to the right and y down
    as one who reads the tag sees it, z into the tag.
    """

    error: float = 0.0
    """The mean distance between the corners and where the pose puts them. [px]"""

    ambiguity: float = 0.0
    """`error` as a share of that of the other pose under which the tag looks nearly the same, 0 to 1: close to 1,
    either of both may be the true one.
    """


@standard("jde_msgs/msg/TagDetections")
class TagDetections:
    """The tags in a picture, by family and number."""

    header: Header = field(default_factory=Header)
    """Time at which the picture was taken, and the frame of the camera."""

    left_out: int = 0
    """Number of tags that did not fit below."""

    tags: Sequence[TagDetection] = field(default_factory=list)
    """The tags."""


@standard("jde_msgs/msg/Person")
class Person:
    """A person."""

    id: int = 0
    """The number of the person, from 1, as long as the schema is awake."""

    position: Point2D = field(default_factory=Point2D)
    """The position."""

    velocity: Sequence[float] = field(default_factory=lambda: [0.0] * 2)
    """The velocity along x and y. [m/s]"""

    deviation: float = 0.0
    """Standard deviation of the position along each axis. [m]"""

    confidence: float = 0.0
    """How probable it is that this is a person, 0 to 1."""

    unseen: float = 0.0
    """How long the person has not been seen. [s]"""


@standard("jde_msgs/msg/Persons")
class Persons:
    """The persons around a robot."""

    header: Header = field(default_factory=Header)
    """Time of the scan, and the frame of the positions."""

    persons: Sequence[Person] = field(default_factory=list)
    """The persons."""


@standard("sensor_msgs/msg/BatteryState")
class BatteryState:
    """State of the battery. NaN marks what is not measured."""

    header: Header = field(default_factory=Header)
    """Time."""

    voltage: float = math.nan
    """Voltage. [V]"""

    temperature: float = math.nan
    """Temperature. [degC]"""

    current: float = math.nan
    """Current; negative while discharging. [A]"""

    charge: float = math.nan
    """Present charge. [Ah]"""

    capacity: float = math.nan
    """Charge when it was last full. [Ah]"""

    design_capacity: float = math.nan
    """Nominal charge. [Ah]"""

    percentage: float = math.nan
    """Charge, from 0 to 1."""

    power_supply_status: int = 0
    """0 unknown, 1 charging, 2 discharging, 3 not charging, 4 full."""

    power_supply_health: int = 0
    """0 unknown, 1 good, 2 too hot, 3 dead, 4 overvoltage, 5 failure, 6 too cold, 7 and 8 a timer expired."""

    power_supply_technology: int = 0
    """0 unknown, 1 NiMH, 2 Li-ion, 3 Li-polymer, 4 LiFe, 5 NiCd, 6 LiMn."""

    present: bool = False
    """Whether a battery is present."""

    cell_voltage: Sequence[float] = field(default_factory=list)
    """Voltage of each cell. [V]"""

    cell_temperature: Sequence[float] = field(default_factory=list)
    """Temperature of each cell. [degC]"""

    location: str = ""
    """Location of the battery."""

    serial_number: str = ""
    """Its serial number."""


@standard("jde_msgs/msg/Bumpers")
class Bumpers(_standard.BumpersFunctions):
    """Which bumpers are pressed."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the base."""

    front: Sequence[bool] = field(default_factory=list)
    """Front bumpers, from left to right."""

    rear: Sequence[bool] = field(default_factory=list)
    """Rear bumpers, from left to right in the direction of travel."""

    stalled: bool = False
    """Whether the wheels are blocked while driven."""


@standard("jde_msgs/msg/LineSensor")
class LineSensor:
    """The floor as a row of up to 32 reflectance cells sees it."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the base."""

    cells: Sequence[Point2D] = field(default_factory=list)
    """Position of each cell, in the frame of the base."""

    brightness: Sequence[float] = field(default_factory=list)
    """Brightness of the floor below each cell, from 0 (black) to 1 (white)."""


@standard("sensor_msgs/msg/Imu")
class Imu:
    """Measurement of an inertial unit. Covariances are row by row; one of zeros is unknown."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the unit."""

    orientation: Quaternion = field(default_factory=Quaternion)
    """Orientation in a fixed frame with z up (REP-145)."""

    orientation_covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Covariance of the rotations about x, y and z, rad²; the first is −1 if there is no orientation."""

    angular_velocity: Vector3 = field(default_factory=Vector3)
    """Turn rates about the unit's axes, rad/s."""

    angular_velocity_covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Their covariance, (rad/s)²."""

    linear_acceleration: Vector3 = field(default_factory=Vector3)
    """Specific forces along the unit's axes, m/s²: at rest, the axis that is up shows 9.81 (REP-145)."""

    linear_acceleration_covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Their covariance, (m/s²)²."""


@standard("sensor_msgs/msg/JointState")
class JointState:
    """The state of up to 64 joints. Each list has an element for each joint, in the order of the names, or is empty."""

    header: Header = field(default_factory=Header)
    """Time."""

    name: Sequence[str] = field(default_factory=list)
    """The names of the joints."""

    position: Sequence[float] = field(default_factory=list)
    """Angle, rad; of a joint that slides the distance, m."""

    velocity: Sequence[float] = field(default_factory=list)
    """Velocity, rad/s or m/s."""

    effort: Sequence[float] = field(default_factory=list)
    """Torque, N·m, or force, N."""


@standard("sensor_msgs/msg/NavSatStatus")
class NavSatStatus:
    """Whether a satellite receiver has a fix."""

    status: int = -2
    """-2 unknown, -1 no fix, 0 a fix, 1 one with corrections of satellites, 2 one with corrections of ground stations.
    """

    service: int = 0
    """The systems in use, a sum: 1 GPS, 2 GLONASS, 4 BeiDou, 8 Galileo."""


@standard("sensor_msgs/msg/NavSatFix")
class NavSatFix:
    """A position on the Earth (WGS 84), as a satellite receiver measures it."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the antenna."""

    status: NavSatStatus = field(default_factory=NavSatStatus)
    """Whether there is a fix, and of which systems."""

    latitude: float = 0.0
    """Latitude, positive to the north. [deg]"""

    longitude: float = 0.0
    """Longitude, positive to the east. [deg]"""

    altitude: float = 0.0
    """Height above the ellipsoid; NaN if it is unknown. [m]"""

    position_covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 9)
    """Covariance to the east, to the north and up, row by row. [m2]"""

    position_covariance_type: int = 0
    """The covariance is 0 unknown, 1 estimated, 2 known on its diagonal, 3 known."""


@standard("jde_msgs/msg/PositionFix")
class PositionFix:
    """Measured position on the ground, as of a satellite receiver. ROS has latitude and longitude instead
    (`sensor_msgs/msg/NavSatFix`); a robot that needs none of them is given metres. Without a fix there is no value.
    """

    header: Header = field(default_factory=Header)
    """Time, and the fixed frame of the position."""

    x: float = 0.0
    """Position of the antenna along x. [m]"""

    y: float = 0.0
    """Position of the antenna along y. [m]"""

    covariance: Sequence[float] = field(default_factory=lambda: [0.0] * 4)
    """Covariance of x and y, row by row. [m2]"""


@standard("jde_msgs/msg/WheelEncoders")
class WheelEncoders:
    """Counts of the two wheels' encoders since the driver's first reading."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the base."""

    left: int = 0
    """Ticks of the left wheel. Backward motion counts down; counts never wrap."""

    right: int = 0
    """Ticks of the right wheel."""

    ticks_per_meter: float = 0.0
    """Ticks for one metre of rolling; 0 if unknown. [1/m]"""


@standard("jde_msgs/msg/Connection")
class Connection(_standard.ConnectionFunctions):
    """Connection of a driver to its device."""

    header: Header = field(default_factory=Header)
    """Time of the last change of state, or of the last failed attempt."""

    state: int = 0
    """0 not tried yet, 1 connecting, 2 connected, 3 lost."""

    attempts: int = 0
    """Attempts since the last connection."""

    note: str = ""
    """Name that the device reports, or why it is not connected."""


@standard("jde_msgs/msg/Mission")
class Mission:
    """An application's task and its progress."""

    state: int = 0
    """0 running, 1 done, 2 failed."""

    reached: int = 0
    """Number of targets reached."""

    total: int = 0
    """Number of targets in total."""

    note: str = ""
    """Reason of a failure, or a description of the task."""

    target: Pose2D = field(default_factory=Pose2D)
    """The present target, in the frame of the odometry."""

    distance: float = 0.0
    """Distance to the present target. [m]"""


@standard("jde_msgs/msg/Truth")
class Truth:
    """True state of a simulated robot, independent of its sensors; for measurement, not for control."""

    pose: Pose2D = field(default_factory=Pose2D)
    """Pose in the world."""

    twist: Twist = field(default_factory=Twist)
    """Velocity, in its own frame."""

    clearance: float = 0.0
    """Distance from its edge to the nearest solid object. [m]"""

    min_clearance: float = 0.0
    """Least clearance so far. [m]"""

    collisions: int = 0
    """Contacts with solid objects, each counted once."""


@standard("jde_msgs/msg/Thing")
class Thing:
    """A static or moving object on the floor of a simulated world."""

    name: str = ""
    """Its name in the world's file, cut if it is long."""

    pose: Pose2D = field(default_factory=Pose2D)
    """Center on the floor, and heading."""

    length: float = 0.0
    """Size along its own x: length of a wall, diameter of a round object. [m]"""

    width: float = 0.0
    """Size along its own y; 0 for a wall. [m]"""

    height: float = 0.0
    """Height above the floor. [m]"""

    form: int = 0
    """0 a wall or a box, 1 a cylinder, 2 a ball, 3 a person, 4 a robot, 5 paint on the floor."""

    red: int = 0
    """Its color in sRGB."""

    green: int = 0
    """Its color in sRGB."""

    blue: int = 0
    """Its color in sRGB."""


@standard("jde_msgs/msg/Scenery")
class Scenery:
    """The static objects of a simulated world."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the world."""

    left_out: int = 0
    """Number of objects that did not fit below."""

    things: Sequence[Thing] = field(default_factory=list)
    """The objects."""


@standard("jde_msgs/msg/Movers")
class Movers:
    """The moving and movable objects of a simulated world, without the robot that publishes them."""

    header: Header = field(default_factory=Header)
    """Time, and the frame of the world."""

    left_out: int = 0
    """Number of objects that did not fit below."""

    things: Sequence[Thing] = field(default_factory=list)
    """The objects."""


@standard("std_srvs/srv/Empty_Request")
class Empty_Request:
    """A request without contents."""


@standard("std_srvs/srv/Empty_Response")
class Empty_Response:
    """A response without contents."""


@standard("std_srvs/srv/SetBool_Request")
class SetBool_Request:
    """A request to switch something on or off."""

    data: bool = False
    """On or off."""


@standard("std_srvs/srv/SetBool_Response")
class SetBool_Response:
    """What became of a request to switch something."""

    success: bool = False
    """Whether it was done."""

    message: str = ""
    """What was done, or why it was not."""


@standard("std_srvs/srv/Trigger_Request")
class Trigger_Request:
    """A request without contents, to do what the name of the service says."""


@standard("std_srvs/srv/Trigger_Response")
class Trigger_Response:
    """What became of a request to do something."""

    success: bool = False
    """Whether it was done."""

    message: str = ""
    """What was done, or why it was not."""
