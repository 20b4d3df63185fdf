// mutate.h - damaged inputs for the parsers, the same on every run.
//
// A case has a corpus of good and nearly good inputs and of words that mean
// something to the parser; each round takes one, damages it a few times by a
// seeded generator and holds the parser to a law.  GLINT_LONG=1 goes on for 40
// times as many rounds.  On a crash, and when a law is broken, the input at
// hand is printed in hexadecimal.
#ifndef TESTS_FUZZ_MUTATE_H
#define TESTS_FUZZ_MUTATE_H

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol/bytes.h"
#include "tests/check.h"

static uint64_t state;

// xorshift* (Vigna 2016), uniform below n up to a bias that does not matter.
static inline size_t below(size_t n)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (size_t)((state * 0x2545f4914f6cdd1du) >> 33) % n;
}

static unsigned char *input; // exactly input_size bytes, for the sanitizer
static size_t input_size;

static inline void dump(void)
{
    static const char hex[] = "0123456789abcdef";
    char text[2];
    if (write(STDERR_FILENO, "input: ", 7) < 0)
        return;
    for (size_t i = 0; i < input_size; i++) {
        text[0] = hex[input[i] >> 4];
        text[1] = hex[input[i] & 15];
        if (write(STDERR_FILENO, text, 2) < 0)
            return;
    }
    if (write(STDERR_FILENO, "\n", 1) < 0)
        return;
}

static inline void crashed(int signal_number)
{
    dump();
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

void __asan_on_error(void); // called by the sanitizer where there is one
void __asan_on_error(void)
{
    dump();
}

static inline void use(const struct buf *b)
{
    free(input);
    input_size = b->size;
    input = bytes_alloc(b->size + (b->size == 0));
    if (b->size > 0)
        memcpy(input, b->data, b->size);
}

struct corpus {
    const char *const *texts;
    size_t count;
    const char *const *words; // pieces that mean something to the parser
    size_t word_count;
};

static inline void insert(struct buf *b, size_t at, const void *data,
                          size_t size)
{
    if (size == 0)
        return;
    buf_append(b, data, size);
    memmove(b->data + at + size, b->data + at, b->size - size - at);
    memcpy(b->data + at, data, size);
}

static inline void damage(struct buf *b, const struct corpus *c)
{
    size_t at = below(b->size + 1), n = b->size - at;
    unsigned char byte = (unsigned char)below(256);
    const char *word = c->words[below(c->word_count)];
    switch (below(7)) {
    case 0:
        if (n > 0)
            b->data[at] = byte;
        break;
    case 1:
        if (n > 0)
            b->data[at] ^= (unsigned char)(1u << below(8));
        break;
    case 2:
        insert(b, at, &byte, 1);
        break;
    case 3: // a piece goes
        n = below(n + 1);
        memmove(b->data + at, b->data + at + n, b->size - at - n);
        b->size -= n;
        break;
    case 4: { // a piece comes twice
        struct buf piece = {0};
        buf_append(&piece, b->data + at, below((n < 64 ? n : 64) + 1));
        insert(b, below(b->size + 1), piece.data, piece.size);
        buf_finish(&piece);
        break;
    }
    default:
        insert(b, at, word, strlen(word));
    }
}

static inline void make(struct buf *b, const struct corpus *c)
{
    buf_clear(b);
    buf_byte(b, 0); // so that it has memory even when nothing follows
    buf_clear(b);
    buf_text(b, c->texts[below(c->count)]);
    for (size_t n = below(6); n > 0; n--)
        damage(b, c);
    use(b);
}

static inline size_t rounds(size_t n)
{
    return getenv("GLINT_LONG") ? n * 40 : n;
}

static inline bool within(struct span part, struct span all)
{
    return part.size == 0 ||
           (part.data >= all.data && part.size <= all.size &&
            (size_t)(part.data - all.data) <= all.size - part.size);
}

static inline struct span given(void)
{
    return (struct span){input, input_size};
}

// One failure is enough: it is shown with its input, and the case ends.
#define LAW(x) \
    do { \
        if (!CHECK(x)) { \
            fflush(stdout); \
            dump(); \
            return false; \
        } \
    } while (0)

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define CORPUS(t, w) \
    { \
        t, COUNT(t), w, COUNT(w) \
    }

static inline void run(const char *name, const struct corpus *c, size_t n,
                       bool (*law)(void))
{
    struct buf b = {0};
    check_case(name);
    state = 0x9e3779b97f4a7c15u;
    bool ok = true;
    for (size_t i = 0; ok && i < rounds(n); i++) {
        make(&b, c);
        ok = law();
    }
    buf_finish(&b);
}

static inline bool same(const struct buf *a, const struct buf *b)
{
    return a->size == b->size &&
           (a->size == 0 || memcmp(a->data, b->data, a->size) == 0);
}

// Prints the input when the program crashes.
static inline void catch_crashes(void)
{
    signal(SIGSEGV, crashed);
    signal(SIGABRT, crashed);
}

#endif
