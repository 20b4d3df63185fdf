// check.h - the few words every C test speaks.
//
// A test program calls check_case("name") before each case and check_end() at
// the end of main.  Output, read by tests/run.py: "ok NAME", "not ok NAME",
// "skip NAME: reason".  Exit status 0, 1 when a case failed, 77 when all were
// skipped.
#ifndef TESTS_CHECK_H
#define TESTS_CHECK_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

// Weak, so that a test and the helpers linked into it count together.
#define CHECK_SHARED_ __attribute__((weak))
// the name is copied: it may be a caller's scratch
CHECK_SHARED_ char check_text_[160];
CHECK_SHARED_ const char *check_name_;
CHECK_SHARED_ int check_bad_, check_failed_, check_passed_, check_skipped_;

static inline void check_close_(void)
{
    if (!check_name_)
        return;
    printf("%s %s\n", check_bad_ ? "not ok" : "ok", check_name_);
    fflush(stdout);
    check_bad_ ? check_failed_++ : check_passed_++;
    check_name_ = NULL;
}

// Begins a case; the one before it ends.
static inline void check_case(const char *name)
{
    check_close_();
    snprintf(check_text_, sizeof check_text_, "%s", name);
    check_name_ = check_text_;
    check_bad_ = 0;
}

// The current case cannot be run here.
static inline void check_skip(const char *reason)
{
    printf("skip %s: %s\n", check_name_ ? check_name_ : "?", reason);
    fflush(stdout);
    check_name_ = NULL;
    check_skipped_++;
}

static inline int check_end(void)
{
    check_close_();
    if (check_failed_)
        return 1;
    return check_passed_ == 0 && check_skipped_ > 0 ? 77 : 0;
}

static inline bool check_true_(bool ok, const char *what, const char *file,
                               int line)
{
    if (!ok) {
        printf("  %s:%d: false: %s\n", file, line, what);
        check_bad_++;
    }
    return ok;
}
#define CHECK(x) check_true_((x), #x, __FILE__, __LINE__)

// |got - want| <= tol * max(1, |want|), written so that a NaN fails.
static inline bool check_near_(double got, double want, double tol,
                               const char *what, const char *at)
{
    bool ok = fabs(got - want) <= tol * fmax(1.0, fabs(want));
    if (!ok) {
        printf("  %s: %s: got %.9g, want %.9g, difference %.3g, tolerance "
               "%.3g\n",
               at, what, got, want, got - want, tol);
        check_bad_++;
    }
    return ok;
}
#define CHECK_STR2_(x) #x
#define CHECK_STR_(x) CHECK_STR2_(x)
#define CHECK_NEAR(got, want, tol) \
    check_near_((double)(got), (double)(want), (tol), #got, \
                __FILE__ ":" CHECK_STR_(__LINE__))

// Like CHECK_NEAR, but for a quantity that must not exceed a limit.
static inline bool check_atmost_(double got, double limit, const char *what,
                                 const char *at)
{
    bool ok = got <= limit;
    if (!ok) {
        printf("  %s: %s: got %.9g, must be at most %.9g\n", at, what, got,
               limit);
        check_bad_++;
    }
    return ok;
}
#define CHECK_ATMOST(got, limit) \
    check_atmost_((double)(got), (double)(limit), #got, \
                  __FILE__ ":" CHECK_STR_(__LINE__))

#define CHECK_STR(got, want) \
    do { \
        const char *g_ = (got), *w_ = (want); \
        if (!g_ || strcmp(g_, w_) != 0) { \
            printf("  %s:%d: %s: got \"%s\", want \"%s\"\n", __FILE__, \
                   __LINE__, #got, g_ ? g_ : "(null)", w_); \
            check_bad_++; \
        } \
    } while (0)

#endif
