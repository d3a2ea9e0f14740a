/*
 * The standard types of sensors and actuators, as values in C++: the structures of jde_types.h.
 *
 * Generated from plugin/types; `cargo xtask headers` renews it.
 */
#ifndef JDE_TYPES_HPP
#define JDE_TYPES_HPP

#include "value.hpp"

JDE_DESCRIBED(jde_bool, jde_bool_type);
JDE_DESCRIBED(jde_uint8, jde_uint8_type);
JDE_DESCRIBED(jde_uint16, jde_uint16_type);
JDE_DESCRIBED(jde_uint32, jde_uint32_type);
JDE_DESCRIBED(jde_uint64, jde_uint64_type);
JDE_DESCRIBED(jde_int8, jde_int8_type);
JDE_DESCRIBED(jde_int16, jde_int16_type);
JDE_DESCRIBED(jde_int32, jde_int32_type);
JDE_DESCRIBED(jde_int64, jde_int64_type);
JDE_DESCRIBED(jde_float32, jde_float32_type);
JDE_DESCRIBED(jde_float64, jde_float64_type);
JDE_DESCRIBED(jde_time, jde_time_type);
JDE_DESCRIBED(jde_header, jde_header_type);
JDE_DESCRIBED(jde_point, jde_point_type);
JDE_DESCRIBED(jde_vector3, jde_vector3_type);
JDE_DESCRIBED(jde_quaternion, jde_quaternion_type);
JDE_DESCRIBED(jde_pose, jde_pose_type);
JDE_DESCRIBED(jde_pose_stamped, jde_pose_stamped_type);
JDE_DESCRIBED(jde_pose_with_covariance, jde_pose_with_covariance_type);
JDE_DESCRIBED(jde_point2d, jde_point2d_type);
JDE_DESCRIBED(jde_pose2d, jde_pose2d_type);
JDE_DESCRIBED(jde_transform, jde_transform_type);
JDE_DESCRIBED(jde_transform_stamped, jde_transform_stamped_type);
JDE_DESCRIBED(jde_twist, jde_twist_type);
JDE_DESCRIBED(jde_twist_with_covariance, jde_twist_with_covariance_type);
JDE_DESCRIBED(jde_chunk, jde_chunk_type);
JDE_DESCRIBED(jde_chunk_step, jde_chunk_step_type);
JDE_DESCRIBED(jde_odometry, jde_odometry_type);
JDE_DESCRIBED(jde_map_meta_data, jde_map_meta_data_type);
JDE_DESCRIBED(jde_occupancy_grid, jde_occupancy_grid_type);
JDE_DESCRIBED(jde_path, jde_path_type);
JDE_DESCRIBED(jde_route, jde_route_type);
JDE_DESCRIBED(jde_start, jde_start_type);
JDE_DESCRIBED(jde_target, jde_target_type);
JDE_DESCRIBED(jde_footprint, jde_footprint_type);
JDE_DESCRIBED(jde_mount, jde_mount_type);
JDE_DESCRIBED(jde_body, jde_body_type);
JDE_DESCRIBED(jde_zone, jde_zone_type);
JDE_DESCRIBED(jde_zones, jde_zones_type);
JDE_DESCRIBED(jde_strip, jde_strip_type);
JDE_DESCRIBED(jde_lanes, jde_lanes_type);
JDE_DESCRIBED(jde_laser_scan, jde_laser_scan_type);
JDE_DESCRIBED(jde_range, jde_range_type);
JDE_DESCRIBED(jde_range_ring, jde_range_ring_type);
JDE_DESCRIBED(jde_image, jde_image_type);
JDE_DESCRIBED(jde_compressed_image, jde_compressed_image_type);
JDE_DESCRIBED(jde_region_of_interest, jde_region_of_interest_type);
JDE_DESCRIBED(jde_camera_info, jde_camera_info_type);
JDE_DESCRIBED(jde_point_field, jde_point_field_type);
JDE_DESCRIBED(jde_point_cloud2, jde_point_cloud2_type);
JDE_DESCRIBED(jde_pan_tilt, jde_pan_tilt_type);
JDE_DESCRIBED(jde_color_blob, jde_color_blob_type);
JDE_DESCRIBED(jde_color_blobs, jde_color_blobs_type);
JDE_DESCRIBED(jde_tag_detection, jde_tag_detection_type);
JDE_DESCRIBED(jde_tag_detections, jde_tag_detections_type);
JDE_DESCRIBED(jde_person, jde_person_type);
JDE_DESCRIBED(jde_persons, jde_persons_type);
JDE_DESCRIBED(jde_battery_state, jde_battery_state_type);
JDE_DESCRIBED(jde_bumpers, jde_bumpers_type);
JDE_DESCRIBED(jde_line_sensor, jde_line_sensor_type);
JDE_DESCRIBED(jde_imu, jde_imu_type);
JDE_DESCRIBED(jde_name, jde_name_type);
JDE_DESCRIBED(jde_joint_state, jde_joint_state_type);
JDE_DESCRIBED(jde_nav_sat_status, jde_nav_sat_status_type);
JDE_DESCRIBED(jde_nav_sat_fix, jde_nav_sat_fix_type);
JDE_DESCRIBED(jde_position_fix, jde_position_fix_type);
JDE_DESCRIBED(jde_wheel_encoders, jde_wheel_encoders_type);
JDE_DESCRIBED(jde_connection, jde_connection_type);
JDE_DESCRIBED(jde_mission, jde_mission_type);
JDE_DESCRIBED(jde_truth, jde_truth_type);
JDE_DESCRIBED(jde_thing, jde_thing_type);
JDE_DESCRIBED(jde_scenery, jde_scenery_type);
JDE_DESCRIBED(jde_movers, jde_movers_type);
JDE_DESCRIBED(jde_empty_request, jde_empty_request_type);
JDE_DESCRIBED(jde_empty_response, jde_empty_response_type);
JDE_DESCRIBED(jde_set_bool_request, jde_set_bool_request_type);
JDE_DESCRIBED(jde_set_bool_response, jde_set_bool_response_type);
JDE_DESCRIBED(jde_trigger_request, jde_trigger_request_type);
JDE_DESCRIBED(jde_trigger_response, jde_trigger_response_type);

namespace jde {

using Bool = jde_bool;
using UInt8 = jde_uint8;
using UInt16 = jde_uint16;
using UInt32 = jde_uint32;
using UInt64 = jde_uint64;
using Int8 = jde_int8;
using Int16 = jde_int16;
using Int32 = jde_int32;
using Int64 = jde_int64;
using Float32 = jde_float32;
using Float64 = jde_float64;
using Time = jde_time;
using Header = jde_header;
using Point = jde_point;
using Vector3 = jde_vector3;
using Quaternion = jde_quaternion;
using Pose = jde_pose;
using PoseStamped = jde_pose_stamped;
using PoseWithCovariance = jde_pose_with_covariance;
using Point2D = jde_point2d;
using Pose2D = jde_pose2d;
using Transform = jde_transform;
using TransformStamped = jde_transform_stamped;
using Twist = jde_twist;
using TwistWithCovariance = jde_twist_with_covariance;
using Chunk = jde_chunk;
using ChunkStep = jde_chunk_step;
using Odometry = jde_odometry;
using MapMetaData = jde_map_meta_data;
using OccupancyGrid = jde_occupancy_grid;
using Path = jde_path;
using Route = jde_route;
using Start = jde_start;
using Target = jde_target;
using Footprint = jde_footprint;
using Mount = jde_mount;
using Body = jde_body;
using Zone = jde_zone;
using Zones = jde_zones;
using Strip = jde_strip;
using Lanes = jde_lanes;
using LaserScan = jde_laser_scan;
using Range = jde_range;
using RangeRing = jde_range_ring;
using Image = jde_image;
using CompressedImage = jde_compressed_image;
using RegionOfInterest = jde_region_of_interest;
using CameraInfo = jde_camera_info;
using PointField = jde_point_field;
using PointCloud2 = jde_point_cloud2;
using PanTilt = jde_pan_tilt;
using ColorBlob = jde_color_blob;
using ColorBlobs = jde_color_blobs;
using TagDetection = jde_tag_detection;
using TagDetections = jde_tag_detections;
using Person = jde_person;
using Persons = jde_persons;
using BatteryState = jde_battery_state;
using Bumpers = jde_bumpers;
using LineSensor = jde_line_sensor;
using Imu = jde_imu;
using Name = jde_name;
using JointState = jde_joint_state;
using NavSatStatus = jde_nav_sat_status;
using NavSatFix = jde_nav_sat_fix;
using PositionFix = jde_position_fix;
using WheelEncoders = jde_wheel_encoders;
using Connection = jde_connection;
using Mission = jde_mission;
using Truth = jde_truth;
using Thing = jde_thing;
using Scenery = jde_scenery;
using Movers = jde_movers;
using Empty_Request = jde_empty_request;
using Empty_Response = jde_empty_response;
using SetBool_Request = jde_set_bool_request;
using SetBool_Response = jde_set_bool_response;
using Trigger_Request = jde_trigger_request;
using Trigger_Response = jde_trigger_response;

} // namespace jde

#endif
