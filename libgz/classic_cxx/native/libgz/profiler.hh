/* Marks of a profiler, which measures nothing here, as in Gazebo without IGN_PROFILER_ENABLE.
 * License: Apache License 2.0.
 */
#ifndef LIBGZ_PROFILER_HH
#define LIBGZ_PROFILER_HH
#define IGN_PROFILE_THREAD_NAME(name) ((void) name)
#define IGN_PROFILE_LOG_TEXT(text) ((void) text)
#define IGN_PROFILE_BEGIN(name) ((void) name)
#define IGN_PROFILE_END() ((void) 0)
#define IGN_PROFILE(name) ((void) name)
#endif
