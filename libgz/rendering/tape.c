/* Plays calls of OpenGL's functions that Python has recorded, without the interpreter lock; see tape.py. Functions come as
   addresses, so nothing is linked. */

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { MOST_ARGUMENTS = 10 };

/* Mirrored by `_LAYOUT` in tape.py. */
typedef struct call {
    void (*function)(void);
    void (*play)(const struct call *); /* passes as many arguments of such types, see FORMS */
    union {
        int64_t whole;
        double real;
        void *place;
    } arguments[MOST_ARGUMENTS];
} call;

#define I(k) ((int)c->arguments[k].whole)
#define F(k) ((float)c->arguments[k].real)
#define D(k) (c->arguments[k].real)
#define P(k) (c->arguments[k].place)

/* What arguments functions have: i int, f float, d double, p pointer. */
#define FORMS(FORM) \
    FORM(, (void)) \
    FORM(i, (int), I(0)) \
    FORM(ii, (int, int), I(0), I(1)) \
    FORM(iii, (int, int, int), I(0), I(1), I(2)) \
    FORM(iiii, (int, int, int, int), I(0), I(1), I(2), I(3)) \
    FORM(iiiii, (int, int, int, int, int), I(0), I(1), I(2), I(3), I(4)) \
    FORM(iiiiiiiiii, (int, int, int, int, int, int, int, int, int, int), \
         I(0), I(1), I(2), I(3), I(4), I(5), I(6), I(7), I(8), I(9)) \
    FORM(if, (int, float), I(0), F(1)) \
    FORM(iif, (int, int, float), I(0), I(1), F(2)) \
    FORM(ifff, (int, float, float, float), I(0), F(1), F(2), F(3)) \
    FORM(ff, (float, float), F(0), F(1)) \
    FORM(fff, (float, float, float), F(0), F(1), F(2)) \
    FORM(ffff, (float, float, float, float), F(0), F(1), F(2), F(3)) \
    FORM(ddd, (double, double, double), D(0), D(1), D(2)) \
    FORM(p, (void *), P(0)) \
    FORM(ppi, (void *, void *, size_t), P(0), P(1), (size_t)c->arguments[2].whole) \
    FORM(ip, (int, void *), I(0), P(1)) \
    FORM(iip, (int, int, void *), I(0), I(1), P(2)) \
    FORM(iiip, (int, int, int, void *), I(0), I(1), I(2), P(3)) \
    FORM(iiiiiip, (int, int, int, int, int, int, void *), I(0), I(1), I(2), I(3), I(4), I(5), P(6)) \
    FORM(iiiiiiiip, (int, int, int, int, int, int, int, int, void *), \
         I(0), I(1), I(2), I(3), I(4), I(5), I(6), I(7), P(8))

#define PLAYER(form, types, ...) \
    static void play_##form(const call *c) { ((void(*) types)c->function)(__VA_ARGS__); }
FORMS(PLAYER)

#define ROW(form, ...) {#form, play_##form},
static const struct {
    const char *form;
    void (*play)(const call *);
} players[] = {FORMS(ROW)};

/* What plays calls of a form; NULL: there is none. */
void (*gz_player(const char *form))(const call *)
{
    for (size_t i = 0; i < sizeof players / sizeof *players; i++)
        if (!strcmp(form, players[i].form))
            return players[i].play;
    return NULL;
}

size_t gz_call_size(void)
{
    return sizeof(call);
}

/* Play calls, one after the other; the error that OpenGL has recorded, 0 for none. */
unsigned gz_play(const call *calls, int64_t count, unsigned (*get_error)(void))
{
    for (int64_t i = 0; i < count; i++)
        calls[i].play(calls + i);
    return get_error();
}
