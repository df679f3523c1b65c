/* gz_error_*: the last text, and whether it is printed. */

#include "error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gazebo.h"

static int printing = 1;
static int wanted_level = 9;
static char last_text[1024];

void gz_error_init(int print, int level)
{
    printing = print;
    wanted_level = level;
}

const char *gz_error_str(void)
{
    return last_text;
}

void gz_error_report(int level, const char *file, int line, const char *format, ...)
{
    const char *name = strrchr(file, '/');
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(last_text, sizeof last_text, format, arguments);
    va_end(arguments);
    if (level == GZ_ALWAYS ? printing : level <= wanted_level)
        fprintf(stderr, "%s:%d %s\n", name ? name + 1 : file, line, last_text);
}

void gz_server_path(char path[GZ_PATH_SIZE], int server_id)
{
    const char *place = getenv("TMP"), *user = getenv("USER");

    snprintf(path, GZ_PATH_SIZE, "%s/gazebo-%s-%d", place ? place : "/tmp", user ? user : "nobody", server_id);
}
