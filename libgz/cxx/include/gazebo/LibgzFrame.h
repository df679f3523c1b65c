/* A method of a plugin that runs. License: Apache License 2.0. */

#ifndef LIBGZ_FRAME_H
#define LIBGZ_FRAME_H

typedef struct libgz_frame
{
  struct libgz_frame *below;
  const char *method;
  const char *label; /* plugin and model */
  int failed; /* a function of libgz failed, and the method is to end */
} libgz_frame;

#endif
