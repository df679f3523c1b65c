/*
 * libgazebo: reading and commanding the models of a running server.
 *
 * Generated from the declarations in interfaces/ by `python -m libgz.clib.header`; edit those instead.
 *
 * Structs are those of version 0x060 (Gazebo 0.6 and 0.7), with the later ir and actarray. Define
 * GAZEBO_GRIPPER_CVS for the gripper struct of late 2006. With LIBGAZEBO_VERSION defined as 0x050, truth and camera are
 * those of Gazebo 0.5; the library must have been compiled with the same definition.
 *
 * Functions return 0, or -1 after printing an error, which gz_error_str returns. Lengths are in metres, angles in
 * radians, times in seconds. The server writes fields marked [S], clients write those marked [C].
 * License: Apache License 2.0.
 */

#ifndef GAZEBO_H
#define GAZEBO_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h> /* programs rely on it: atof without a declaration returns garbage */
#include <sys/types.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef LIBGAZEBO_VERSION
#define LIBGAZEBO_VERSION 0x060
#endif
#define GZ_SEM_KEY 0x135135fa /* plus the server id: the key of its semaphores */
#define GAZEBO_MAX_MODEL_TYPE 128
#define GZ_CLIENT_ID_USER_FIRST 0
#define GZ_CLIENT_ID_USER_LAST 7
#define GZ_CLIENT_ID_WXGAZEBO 8
#define GZ_CLIENT_ID_PLAYER 9

/* Whether errors are printed, and the level up to which messages are: 1 connections, 5 files, 9 all. */
extern void gz_error_init(int print, int level);
extern const char *gz_error_str(void);

/* A server: a directory and the semaphores that wake clients. */
typedef struct gz_server {
    int server_id;
    char *filename; /* of the directory */
    int sem_key;
    int sem_cid;
} gz_server_t;

extern gz_server_t *gz_server_alloc(void);
extern void gz_server_free(gz_server_t *self);
extern int gz_server_init(gz_server_t *self, int server_id, int force);
extern int gz_server_fini(gz_server_t *self);
extern int gz_server_post(gz_server_t *self); /* wakes all clients */

/* A client. Each client that waits needs its own id, 0 to 7. */
typedef struct gz_client {
    int server_id;
    int client_id;
    char *filename; /* of the server's directory */
    int sem_key;
    int sem_cid;
} gz_client_t;

extern gz_client_t *gz_client_alloc(void);
extern void gz_client_free(gz_client_t *self);
extern int gz_client_query(gz_client_t *self, int server_id); /* 0 present, 1 absent, -1 error */
extern int gz_client_connect(gz_client_t *self, int server_id);
extern int gz_client_connect_wait(gz_client_t *self, int server_id, int client_id);
extern int gz_client_disconnect(gz_client_t *self);
extern int gz_client_wait(gz_client_t *self); /* sleeps until a post: of a step, or of any device */

/* The first field of every data struct. */
typedef struct gz_data {
    int version;
    size_t size;
    char model_type[GAZEBO_MAX_MODEL_TYPE];
    int model_id;
    int parent_model_id;
} gz_data_t;

/* A mapped file of any struct. */
typedef struct gz_iface {
    gz_server_t *server;
    gz_client_t *client;
    int mmap_fd;
    void *mmap;
    char *filename;
} gz_iface_t;

extern gz_iface_t *gz_iface_alloc(void);
extern void gz_iface_free(gz_iface_t *self);
extern int gz_iface_create(gz_iface_t *self, gz_server_t *server, const char *type, const char *id, size_t size);
extern int gz_iface_destroy(gz_iface_t *self);
extern int gz_iface_open(gz_iface_t *self, gz_client_t *client, const char *type, const char *id, size_t size);
extern int gz_iface_close(gz_iface_t *self);
extern int gz_iface_lock(gz_iface_t *self, int blocking); /* always blocks */
extern void gz_iface_unlock(gz_iface_t *self);
extern int gz_iface_post(gz_iface_t *self);

/* actarray: an array of actuators, such as an arm. */
#define GAZEBO_ACTARRAY_NUM_ACTUATORS 16
#define GAZEBO_ACTARRAY_JOINT_POSITION_MODE 0
#define GAZEBO_ACTARRAY_JOINT_SPEED_MODE 1
#define GAZEBO_ACTARRAY_JOINT_CURRENT_MODE 2
#define GAZEBO_ACTARRAY_ACTSTATE_IDLE 1
#define GAZEBO_ACTARRAY_ACTSTATE_MOVING 2
#define GAZEBO_ACTARRAY_ACTSTATE_BRAKED 3
#define GAZEBO_ACTARRAY_ACTSTATE_STALLED 4

typedef struct gazebo_actarray_actuator {
    float position; /* [S] measured position [m or rad] */
    float speed; /* [S] measured speed [m/s or rad/s] */
    uint8_t state; /* [S] GAZEBO_ACTARRAY_ACTSTATE_* */
} gazebo_actarray_actuator_t;

typedef struct gz_actarray_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    unsigned int new_cmd; /* [C] set to another value with each command */
    unsigned int actuators_count; /* [S] number of actuators, at most 16 */
    gazebo_actarray_actuator_t actuators_data[16]; /* [S] the actuators */
    float cmd_pos[16]; /* [C] wanted positions [m or rad] */
    float cmd_speed[16]; /* [C] wanted speeds [m/s or rad/s] */
    float cmd_current[16]; /* [C] wanted currents [A] */
    unsigned int joint_mode[16]; /* [C] 0 position, 1 speed, 2 current */
} gz_actarray_data_t;

typedef struct gz_actarray {
    gz_data_t head; /* unused */
    gz_iface_t *iface;
    gz_actarray_data_t *data;
} gz_actarray_t;

extern gz_actarray_t *gz_actarray_alloc(void);
extern void gz_actarray_free(gz_actarray_t *self);
extern int gz_actarray_create(gz_actarray_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_actarray_destroy(gz_actarray_t *self);
extern int gz_actarray_open(gz_actarray_t *self, gz_client_t *client, const char *id);
extern int gz_actarray_close(gz_actarray_t *self);
extern int gz_actarray_lock(gz_actarray_t *self, int blocking);
extern void gz_actarray_unlock(gz_actarray_t *self);
extern int gz_actarray_post(gz_actarray_t *self);

/* camera: the images of a camera. */

#if LIBGAZEBO_VERSION == 0x050
#define GAZEBO_CAMERA_MAX_IMAGE_SIZE 230400
typedef struct gz_camera_data {
    gz_data_t head;
    double time; /* [S] sim time of this image [s] */
    unsigned int width; /* [S] width of the image; set before the first image [px] */
    unsigned int height; /* [S] height of the image [px] */
    unsigned int image_size; /* [S] bytes of the image; 0 until the first image [byte] */
    uint8_t image[230400]; /* [S] red, green, blue; top row first */
} gz_camera_data_t;
#else
#define GAZEBO_CAMERA_MAX_IMAGE_SIZE 921600
typedef struct gz_camera_data {
    gz_data_t head;
    double time; /* [S] sim time of this image [s] */
    unsigned int width; /* [S] width of the image; set before the first image [px] */
    unsigned int height; /* [S] height of the image [px] */
    unsigned int image_size; /* [S] bytes of the image; 0 until the first image [byte] */
    uint8_t image[921600]; /* [S] red, green, blue; top row first */
} gz_camera_data_t;
#endif

typedef struct gz_camera {
    gz_iface_t *iface;
    gz_camera_data_t *data;
} gz_camera_t;

extern gz_camera_t *gz_camera_alloc(void);
extern void gz_camera_free(gz_camera_t *self);
extern int gz_camera_create(gz_camera_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_camera_destroy(gz_camera_t *self);
extern int gz_camera_open(gz_camera_t *self, gz_client_t *client, const char *id);
extern int gz_camera_close(gz_camera_t *self);
extern int gz_camera_lock(gz_camera_t *self, int blocking);
extern void gz_camera_unlock(gz_camera_t *self);
extern int gz_camera_post(gz_camera_t *self);

/* factory: adding models to a running world. */
#define GAZEBO_FACTORY_MAX_STRING 4096

typedef struct gz_factory_data {
    gz_data_t head;
    double time; /* [S] sim time at which the server last read the string [s] */
    uint8_t string[4096]; /* [C] XML of one model, with a zero at the end; the server clears it */
} gz_factory_data_t;

typedef struct gz_factory {
    gz_iface_t *iface;
    gz_factory_data_t *data;
} gz_factory_t;

extern gz_factory_t *gz_factory_alloc(void);
extern void gz_factory_free(gz_factory_t *self);
extern int gz_factory_create(gz_factory_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_factory_destroy(gz_factory_t *self);
extern int gz_factory_open(gz_factory_t *self, gz_client_t *client, const char *id);
extern int gz_factory_close(gz_factory_t *self);
extern int gz_factory_lock(gz_factory_t *self, int blocking);
extern void gz_factory_unlock(gz_factory_t *self);

/* fiducial: the poses of marked objects that a sensor recognises. */
#define GZ_FIDUCIAL_MAX_FIDS 401

typedef struct gz_fiducial_fid {
    int id; /* [S] number of the object */
    double pos[3]; /* [S] x, y, z in the sensor's frame [m] */
    double rot[3]; /* [S] roll, pitch, yaw in the sensor's frame [rad] */
} gz_fiducial_fid_t;

typedef struct gz_fiducial_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    int fid_count; /* [S] number of objects in view, at most 401 */
    gz_fiducial_fid_t fids[401]; /* [S] the objects */
} gz_fiducial_data_t;

typedef struct gz_fiducial {
    gz_iface_t *iface;
    gz_fiducial_data_t *data;
} gz_fiducial_t;

extern gz_fiducial_t *gz_fiducial_alloc(void);
extern void gz_fiducial_free(gz_fiducial_t *self);
extern int gz_fiducial_create(gz_fiducial_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_fiducial_destroy(gz_fiducial_t *self);
extern int gz_fiducial_open(gz_fiducial_t *self, gz_client_t *client, const char *id);
extern int gz_fiducial_close(gz_fiducial_t *self);
extern int gz_fiducial_lock(gz_fiducial_t *self, int blocking);
extern void gz_fiducial_unlock(gz_fiducial_t *self);
extern int gz_fiducial_post(gz_fiducial_t *self);

/* gps: a satellite navigation receiver. */

typedef struct gz_gps_data {
    gz_data_t head;
    double time; /* [S] sim time of this fix [s] */
    double utc_time; /* [S] UTC of this fix [s] */
    double latitude; /* [S] north positive [deg] */
    double longitude; /* [S] east positive [deg] */
    double altitude; /* [S] altitude [m] */
    double utm_e; /* [S] UTM easting [m] */
    double utm_n; /* [S] UTM northing [m] */
    int satellites; /* [S] satellites in view */
    int quality; /* [S] 0 no fix, 1 GPS, 2 differential GPS */
    double hdop; /* [S] horizontal dilution of precision */
    double vdop; /* [S] vertical dilution of precision */
    double err_horz; /* [S] horizontal error [m] */
    double err_vert; /* [S] vertical error [m] */
} gz_gps_data_t;

typedef struct gz_gps {
    gz_iface_t *iface;
    gz_gps_data_t *data;
} gz_gps_t;

extern gz_gps_t *gz_gps_alloc(void);
extern void gz_gps_free(gz_gps_t *self);
extern int gz_gps_create(gz_gps_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_gps_destroy(gz_gps_t *self);
extern int gz_gps_open(gz_gps_t *self, gz_client_t *client, const char *id);
extern int gz_gps_close(gz_gps_t *self);
extern int gz_gps_lock(gz_gps_t *self, int blocking);
extern void gz_gps_unlock(gz_gps_t *self);
extern int gz_gps_post(gz_gps_t *self);

/* gripper: two paddles that grip, and a lift that raises them. */
#define GAZEBO_GRIPPER_STATE_OPEN 1
#define GAZEBO_GRIPPER_STATE_CLOSED 2
#define GAZEBO_GRIPPER_STATE_MOVING 3
#define GAZEBO_GRIPPER_STATE_ERROR 4
#define GAZEBO_GRIPPER_CMD_OPEN 1
#define GAZEBO_GRIPPER_CMD_CLOSE 2
#define GAZEBO_GRIPPER_CMD_STOP 3
#define GAZEBO_GRIPPER_CMD_STORE 4
#define GAZEBO_GRIPPER_CMD_RETRIEVE 5

#ifdef GAZEBO_GRIPPER_CVS
typedef struct gz_gripper_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    int cmd; /* [C] as in the release */
    int state; /* [S] GAZEBO_GRIPPER_STATE_* */
    int grip_limit_reach; /* [S] 1: both paddles are at an end of their range */
    int lift_limit_reach; /* [S] 1: the lift is at an end of its range */
    int outer_beam_obstruct; /* [S] 1: an object interrupts the outer beam */
    int inner_beam_obstruct; /* [S] 1: an object interrupts the inner beam */
    int left_paddle_open; /* [S] 1: the left paddle is open */
    int right_paddle_open; /* [S] 1: the right paddle is open */
    int lift_up; /* [S] 1: the lift is up */
    int lift_down; /* [S] 1: the lift is down */
} gz_gripper_data_t;
#else
typedef struct gz_gripper_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    /* [C] 1 open, 2 close, 3 stop, 4 lift up, 5 lift down, 6 lift stop, 7 close and lift, 8 open and lower, 15 halt
       */
    int cmd;
    int lift_limit_reach; /* [S] 1: the lift is at an end of its range */
    int grip_limit_reach; /* [S] 1: both paddles are at an end of their range */
    int outer_beam_obstruct; /* [S] 1: an object interrupts the outer beam */
    int inner_beam_obstruct; /* [S] 1: an object interrupts the inner beam */
    int left_paddle_open; /* [S] 1: the left paddle is open */
    int right_paddle_open; /* [S] 1: the right paddle is open */
    int paddles_opened; /* [S] 1: both paddles are open */
    int paddles_closed; /* [S] 1: the paddles are closed, or hold an object */
    int paddles_moving; /* [S] 1: the paddles are moving */
    int paddles_error; /* [S] 1: the paddles are stuck */
    int lift_up; /* [S] 1: the lift is up */
    int lift_down; /* [S] 1: the lift is down */
    int lift_moving; /* [S] 1: the lift is moving */
    int lift_error; /* [S] 1: the lift is stuck */
} gz_gripper_data_t;
#endif

typedef struct gz_gripper {
    gz_iface_t *iface;
    gz_gripper_data_t *data;
} gz_gripper_t;

extern gz_gripper_t *gz_gripper_alloc(void);
extern void gz_gripper_free(gz_gripper_t *self);
extern int gz_gripper_create(gz_gripper_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_gripper_destroy(gz_gripper_t *self);
extern int gz_gripper_open(gz_gripper_t *self, gz_client_t *client, const char *id);
extern int gz_gripper_close(gz_gripper_t *self);
extern int gz_gripper_lock(gz_gripper_t *self, int blocking);
extern void gz_gripper_unlock(gz_gripper_t *self);

#ifdef GAZEBO_GRIPPER_CVS
#define gz_gripper_open(self, client, id) \
    (gz_iface_open((self)->iface, client, "gripper", id, sizeof(gz_gripper_data_t)) != 0 \
         ? -1 \
         : ((self)->data = (gz_gripper_data_t *) (self)->iface->mmap, 0))
#endif

/* guicam: a camera that is moved with the mouse. */
#define GAZEBO_GUICAM_MAX_IMAGE_SIZE 2359296

typedef struct gz_guicam_data {
    gz_data_t head;
    double sim_time; /* [S] sim time of the last update [s] */
    double pause_time; /* [S] pause time of the last update [s] */
    double pos[3]; /* [S] position of the camera: x, y, z [m] */
    double rot[3]; /* [S] rotation of the camera: roll, pitch, yaw [rad] */
    int cmd_spot_mode; /* [C] effect of dragging: 0 translate, 1 zoom, 2 rotate */
    int cmd_spot_state; /* [C] 1 while dragging, else 0 */
    double cmd_spot_a[2]; /* [C] start of the drag: x, y [px] */
    double cmd_spot_b[2]; /* [C] current position of the drag: x, y [px] */
    int roll_lock; /* [S/C] 1: keep the camera level */
    int display_bbox; /* [S/C] 1: render bounding boxes */
    int display_axes; /* [S/C] 1: render the axes of named bodies */
    int display_com; /* [S/C] 1: render centres of mass */
    int display_skins; /* [S/C] 1: render skins instead of collision shapes */
    int display_rays; /* [S/C] 1: render the rays of lasers and sonars */
    int display_frustrums; /* [S/C] 1: render the frustums of cameras */
    int display_materials; /* [S/C] 1: render colours */
    int display_textures; /* [S/C] 1: render textures */
    int polygon_fill; /* [S/C] 1: fill polygons; 0: render their edges only */
    int shade_smooth; /* [S/C] 1: smooth shading; 0: flat shading */
    int save_frames; /* [S/C] 1: save every image, at a client's request at most 1000 */
    unsigned int width; /* [S] width of the image [px] */
    unsigned int height; /* [S] height of the image [px] */
    uint8_t image[2359296]; /* [S] red, green, blue; top row first */
    unsigned int image_size; /* [S] bytes of the image [byte] */
} gz_guicam_data_t;

typedef struct gz_guicam {
    gz_iface_t *iface;
    gz_guicam_data_t *data;
} gz_guicam_t;

extern gz_guicam_t *gz_guicam_alloc(void);
extern void gz_guicam_free(gz_guicam_t *self);
extern int gz_guicam_create(gz_guicam_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_guicam_destroy(gz_guicam_t *self);
extern int gz_guicam_open(gz_guicam_t *self, gz_client_t *client, const char *id);
extern int gz_guicam_close(gz_guicam_t *self);
extern int gz_guicam_lock(gz_guicam_t *self, int blocking);
extern void gz_guicam_unlock(gz_guicam_t *self);
extern int gz_guicam_post(gz_guicam_t *self);

/* ir: the ranges of infrared sensors. */
#define GZ_IR_MAX_RANGES 48

typedef struct gz_ir_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double max_range; /* [S] reading of a sensor that detects nothing [m] */
    int ir_count; /* [S] number of sensors, at most 48 */
    double ir_pos[48][3]; /* [S] positions in the robot's frame [m] */
    double ir_rot[48][3]; /* [S] rotations in the robot's frame: roll, pitch, yaw [rad] */
    double ir_ranges[48]; /* [S] measured distances [m] */
    int cmd_enable_ir; /* [C] 0 or 1 */
} gz_ir_data_t;

typedef struct gz_ir {
    gz_iface_t *iface;
    gz_ir_data_t *data;
} gz_ir_t;

extern gz_ir_t *gz_ir_alloc(void);
extern void gz_ir_free(gz_ir_t *self);
extern int gz_ir_create(gz_ir_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_ir_destroy(gz_ir_t *self);
extern int gz_ir_open(gz_ir_t *self, gz_client_t *client, const char *id);
extern int gz_ir_close(gz_ir_t *self);
extern int gz_ir_lock(gz_ir_t *self, int blocking);
extern void gz_ir_unlock(gz_ir_t *self);

/* joint: the joints of a model, and the angles wanted for them. */
#define GAZEBO_JOINT_MAX_JOINTS 20

typedef struct gz_joint_data {
    int type; /* [S] ODE's number of the joint type */
    double anchor[3]; /* [S] global anchor [m] */
    double axis[3]; /* [S] global axis */
    double axis2[3]; /* [S] global second axis of universal and hinge2 joints */
    double angular_velocity; /* [S] about the axis [rad/s] */
    double angular_velocity2; /* [S] about the second axis [rad/s] */
    double angle; /* [S] about the axis [rad] */
    double angle2; /* [S] about the second axis [rad] */
    double cmd_angle; /* [C] wanted angle about the axis [rad] */
    double cmd_angle2; /* [C] wanted angle about the second axis [rad] */
} gz_joint_data_t;

typedef struct gz_joints {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    gz_joint_data_t joints[20]; /* [S] the joints */
    int joint_count; /* [S] number of joints, at most 20 */
} gz_joints_t;

typedef struct gz_joint {
    gz_iface_t *iface;
    gz_joints_t *data;
} gz_joint_t;

extern gz_joint_t *gz_joint_alloc(void);
extern void gz_joint_free(gz_joint_t *self);
extern int gz_joint_create(gz_joint_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_joint_destroy(gz_joint_t *self);
extern int gz_joint_open(gz_joint_t *self, gz_client_t *client, const char *id);
extern int gz_joint_close(gz_joint_t *self);
extern int gz_joint_lock(gz_joint_t *self, int blocking);
extern void gz_joint_unlock(gz_joint_t *self);
extern int gz_joint_post(gz_joint_t *self);

/* laser: the ranges of a scanning laser range-finder. */
#define GZ_LASER_MAX_RANGES 401

typedef struct gz_laser_data {
    gz_data_t head;
    double time; /* [S] sim time of this scan [s] */
    double min_angle; /* [S] direction of the first reading, left positive [rad] */
    double max_angle; /* [S] direction of the last reading [rad] */
    double res_angle; /* [S] angle between readings [rad] */
    double max_range; /* [S] reading where nothing is hit [m] */
    int range_count; /* [S] number of readings, at most 400 */
    double ranges[401]; /* [S] distance from the sensor's centre, counter-clockwise [m] */
    int intensity[401]; /* [S] 1 where a retro-reflector is hit */
    int cmd_new_angle; /* [C] 1: apply the cmd_ fields below; the server clears it */
    int cmd_new_length; /* [C] 1: apply the cmd_ fields below; the server clears it */
    double cmd_max_range; /* [C] wanted maximum range; 0: as it is [m] */
    double cmd_min_angle; /* [C] wanted direction of the first reading [rad] */
    double cmd_max_angle; /* [C] wanted direction of the last reading [rad] */
    int cmd_range_count; /* [C] wanted number of readings; 0: as it is */
} gz_laser_data_t;

typedef struct gz_laser {
    gz_iface_t *iface;
    gz_laser_data_t *data;
} gz_laser_t;

extern gz_laser_t *gz_laser_alloc(void);
extern void gz_laser_free(gz_laser_t *self);
extern int gz_laser_create(gz_laser_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_laser_destroy(gz_laser_t *self);
extern int gz_laser_open(gz_laser_t *self, gz_client_t *client, const char *id);
extern int gz_laser_close(gz_laser_t *self);
extern int gz_laser_lock(gz_laser_t *self, int blocking);
extern void gz_laser_unlock(gz_laser_t *self);
extern int gz_laser_post(gz_laser_t *self);

/* position: the odometry of a robot, and its velocity commands. */

typedef struct gz_position_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double pos[3]; /* [S] x, y, z; on wheeled robots by odometry, zero at the start [m] */
    double rot[3]; /* [S] roll, pitch, yaw; wheeled robots write yaw only [rad] */
    double vel_pos[3]; /* [S] velocity in the robot's frame, forward first [m/s] */
    double vel_rot[3]; /* [S] angular velocity; the third is the yaw rate, left positive [rad/s] */
    int stall; /* [S] 1: the motors are stalled */
    int cmd_enable_motors; /* [C] 1: motors on; 0 stops the wheels. The server sets 1 at the start */
    double cmd_vel_pos[3]; /* [C] wanted velocity in the robot's frame, forward first [m/s] */
    double cmd_vel_rot[3]; /* [C] wanted angular velocity; the third is the yaw rate [rad/s] */
} gz_position_data_t;

typedef struct gz_position {
    gz_iface_t *iface;
    gz_position_data_t *data;
} gz_position_t;

extern gz_position_t *gz_position_alloc(void);
extern void gz_position_free(gz_position_t *self);
extern int gz_position_create(gz_position_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_position_destroy(gz_position_t *self);
extern int gz_position_open(gz_position_t *self, gz_client_t *client, const char *id);
extern int gz_position_close(gz_position_t *self);
extern int gz_position_lock(gz_position_t *self, int blocking);
extern void gz_position_unlock(gz_position_t *self);
extern int gz_position_post(gz_position_t *self);

/* power: the voltages of a robot's batteries. */

typedef struct gz_power_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double levels[10]; /* [S] voltage of each battery; only the first is used [V] */
} gz_power_data_t;

typedef struct gz_power {
    gz_iface_t *iface;
    gz_power_data_t *data;
} gz_power_t;

extern gz_power_t *gz_power_alloc(void);
extern void gz_power_free(gz_power_t *self);
extern int gz_power_create(gz_power_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_power_destroy(gz_power_t *self);
extern int gz_power_open(gz_power_t *self, gz_client_t *client, const char *id);
extern int gz_power_close(gz_power_t *self);
extern int gz_power_lock(gz_power_t *self, int blocking);
extern void gz_power_unlock(gz_power_t *self);
extern int gz_power_post(gz_power_t *self);

/* ptz: a camera head that pans, tilts and zooms. */

typedef struct gz_ptz_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double pan; /* [S] measured pan, left positive [rad] */
    double tilt; /* [S] measured tilt, down positive [rad] */
    double zoom; /* [S] horizontal field of view [rad] */
    double cmd_pan; /* [C] wanted pan [rad] */
    double cmd_tilt; /* [C] wanted tilt [rad] */
    double cmd_zoom; /* [C] wanted field of view; the server writes pi, which is no zoom, at the start [rad] */
} gz_ptz_data_t;

typedef struct gz_ptz {
    gz_data_t head; /* unused */
    gz_iface_t *iface;
    gz_ptz_data_t *data;
} gz_ptz_t;

extern gz_ptz_t *gz_ptz_alloc(void);
extern void gz_ptz_free(gz_ptz_t *self);
extern int gz_ptz_create(gz_ptz_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_ptz_destroy(gz_ptz_t *self);
extern int gz_ptz_open(gz_ptz_t *self, gz_client_t *client, const char *id);
extern int gz_ptz_close(gz_ptz_t *self);
extern int gz_ptz_lock(gz_ptz_t *self, int blocking);
extern void gz_ptz_unlock(gz_ptz_t *self);
extern int gz_ptz_post(gz_ptz_t *self);

/* sim: the times of a simulation, and the commands pause, reset and save. */

typedef struct gz_sim_data {
    gz_data_t head;
    double sim_time; /* [S] sim time, pauses excluded [s] */
    double pause_time; /* [S] time spent paused: one step time for each paused step [s] */
    double real_time; /* [S] wall-clock time since the server started [s] */
    int pause; /* [S/C] 1: paused; the server writes the worldfile's value at the start, then only reads */
    int reset; /* [C] 1: reset all models to their initial poses; the server clears it */
    int save; /* [C] 1: write the poses of top-level models to the worldfile; the server clears it */
} gz_sim_data_t;

typedef struct gz_sim {
    gz_iface_t *iface;
    gz_sim_data_t *data;
} gz_sim_t;

extern gz_sim_t *gz_sim_alloc(void);
extern void gz_sim_free(gz_sim_t *self);
extern int gz_sim_create(gz_sim_t *self, gz_server_t *server, const char *id);
extern int gz_sim_destroy(gz_sim_t *self);
extern int gz_sim_open(gz_sim_t *self, gz_client_t *client, const char *id);
extern int gz_sim_close(gz_sim_t *self);
extern int gz_sim_lock(gz_sim_t *self, int blocking);
extern void gz_sim_unlock(gz_sim_t *self);

/* sonar: the ranges of a ring of ultrasonic sensors. */
#define GZ_SONAR_MAX_RANGES 48

typedef struct gz_sonar_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double max_range; /* [S] reading of a sonar that detects nothing [m] */
    int sonar_count; /* [S] number of sonars, at most 48 */
    double sonar_pos[48][3]; /* [S] positions in the robot's frame [m] */
    double sonar_rot[48][3]; /* [S] rotations in the robot's frame: roll, pitch, yaw [rad] */
    double sonar_ranges[48]; /* [S] measured distances [m] */
    int cmd_enable_sonar; /* [C] 0 or 1; without effect on the Pioneers */
} gz_sonar_data_t;

typedef struct gz_sonar {
    gz_iface_t *iface;
    gz_sonar_data_t *data;
} gz_sonar_t;

extern gz_sonar_t *gz_sonar_alloc(void);
extern void gz_sonar_free(gz_sonar_t *self);
extern int gz_sonar_create(gz_sonar_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_sonar_destroy(gz_sonar_t *self);
extern int gz_sonar_open(gz_sonar_t *self, gz_client_t *client, const char *id);
extern int gz_sonar_close(gz_sonar_t *self);
extern int gz_sonar_lock(gz_sonar_t *self, int blocking);
extern void gz_sonar_unlock(gz_sonar_t *self);

/* stereo: the images and disparities of a stereo camera. */
#define GAZEBO_STEREO_MAX_RGB_SIZE 921600
#define GAZEBO_STEREO_MAX_DISPARITY_SIZE 307200

typedef struct gz_stereo_data {
    gz_data_t head;
    double time; /* [S] sim time of these images [s] */
    unsigned int width; /* [S] width of the images [px] */
    unsigned int height; /* [S] height of the images [px] */
    unsigned int left_image_size; /* [S] bytes of the left image [byte] */
    uint8_t left_image[921600]; /* [S] red, green, blue; top row first */
    unsigned int right_image_size; /* [S] bytes of the right image [byte] */
    uint8_t right_image[921600]; /* [S] red, green, blue; top row first */
    unsigned int left_disparity_size; /* [S] number of left disparities: width times height */
    float left_disparity[307200]; /* [S] shift to the right image [px] */
    unsigned int right_disparity_size; /* [S] number of right disparities */
    float right_disparity[307200]; /* [S] shift to the left image [px] */
} gz_stereo_data_t;

typedef struct gz_stereo {
    gz_iface_t *iface;
    gz_stereo_data_t *data;
} gz_stereo_t;

extern gz_stereo_t *gz_stereo_alloc(void);
extern void gz_stereo_free(gz_stereo_t *self);
extern int gz_stereo_create(gz_stereo_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_stereo_destroy(gz_stereo_t *self);
extern int gz_stereo_open(gz_stereo_t *self, gz_client_t *client, const char *id);
extern int gz_stereo_close(gz_stereo_t *self);
extern int gz_stereo_lock(gz_stereo_t *self, int blocking);
extern void gz_stereo_unlock(gz_stereo_t *self);
extern int gz_stereo_post(gz_stereo_t *self);

/* truth: the true pose of a model, and commands to move it. */

#if LIBGAZEBO_VERSION == 0x050
typedef struct gz_truth_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double pos[3]; /* [S] global x, y, z [m] */
    double rot[3]; /* [S] global rotation: roll, pitch, yaw [rad] */
    int cmd_new; /* [C] 1: move the model to the pose below; written last, cleared by the server */
    double cmd_pos[3]; /* [C] wanted global x, y, z [m] */
    double cmd_rot[3]; /* [C] wanted global rotation: roll, pitch, yaw [rad] */
} gz_truth_data_t;
#else
typedef struct gz_truth_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    double pos[3]; /* [S] global x, y, z [m] */
    double rot[4]; /* [S] global rotation as a quaternion: u, x, y, z */
    int cmd_new; /* [C] 1: move the model to the pose below; written last, cleared by the server */
    double cmd_pos[3]; /* [C] wanted global x, y, z [m] */
    double cmd_rot[4]; /* [C] wanted global rotation: u, x, y, z */
} gz_truth_data_t;
#endif

typedef struct gz_truth {
    gz_iface_t *iface;
    gz_truth_data_t *data;
} gz_truth_t;

extern gz_truth_t *gz_truth_alloc(void);
extern void gz_truth_free(gz_truth_t *self);
extern int gz_truth_create(gz_truth_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_truth_destroy(gz_truth_t *self);
extern int gz_truth_open(gz_truth_t *self, gz_client_t *client, const char *id);
extern int gz_truth_close(gz_truth_t *self);
extern int gz_truth_lock(gz_truth_t *self, int blocking);
extern void gz_truth_unlock(gz_truth_t *self);
extern int gz_truth_post(gz_truth_t *self);

/* Write roll, pitch, yaw [rad] of q into e, and u, x, y, z of e into q. */
extern void gz_truth_euler_from_quatern(gz_truth_t *self, double *e, double *q);
extern void gz_truth_quatern_from_euler(gz_truth_t *self, double *q, double *e);

/* wifi: the wireless links of a robot. */
#define GAZEBO_WIFI_MAX_LINKS 16
#define GAZEBO_WIFI_QUAL_DBM 1

typedef struct gz_wifi_link {
    char ip[32]; /* [S] address of the remote robot, as dotted text */
    uint16_t qual; /* [S] GAZEBO_WIFI_QUAL_DBM */
    uint16_t level; /* [S] signal level, as the low 16 bits of a signed number [dBm] */
    uint16_t noise; /* [S] noise level, as the low 16 bits of a signed number [dBm] */
} gz_wifi_link_t;

typedef struct gz_wifi_data {
    gz_data_t head;
    double time; /* [S] sim time of this sample [s] */
    gz_wifi_link_t links[16]; /* [S] the links */
    uint16_t link_count; /* [S] number of links, at most 16 */
} gz_wifi_data_t;

typedef struct gz_wifi {
    gz_iface_t *iface;
    gz_wifi_data_t *data;
} gz_wifi_t;

extern gz_wifi_t *gz_wifi_alloc(void);
extern void gz_wifi_free(gz_wifi_t *self);
extern int gz_wifi_create(gz_wifi_t *self, gz_server_t *server, const char *id,
    const char *model_type, int model_id, int parent_model_id);
extern int gz_wifi_destroy(gz_wifi_t *self);
extern int gz_wifi_open(gz_wifi_t *self, gz_client_t *client, const char *id);
extern int gz_wifi_close(gz_wifi_t *self);
extern int gz_wifi_lock(gz_wifi_t *self, int blocking);
extern void gz_wifi_unlock(gz_wifi_t *self);

#ifdef __cplusplus
}
#endif

#endif
