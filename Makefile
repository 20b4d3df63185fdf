# Glint. `make run` and `make test` install what is missing and do the rest.
#   make              build/glintd and build/glint
#   make run          build, then serve a built-in groom (ARGS= adds options)
#   make test         all tests; last line "N passed, N failed, N skipped"
#   make front        measure anew what a governor chooses among
#   make bench-edits  what an edit costs: docs/EDITS.md, README's table
#   make bench-scale  how that grows: docs/SCALE.md
#   make extremes     stiff and extreme cases, at length: docs/EXTREMES.md
#   make test-long    the sweeps, soaks and long fuzzing as well
#   make floors       reject an #include that points up a floor
#   make format       clang-format in place;  make check-format  only looks
#   make test-san     all tests under sanitizers, in build/san (SAN=... for others)
#   make test-clang   all tests as another compiler builds them, in build/clang
#   SAN=address,undefined, CC=clang, V=1 (show commands) go with every target
CC ?= cc
OPT ?= -O2
ARGS ?=
SAN ?=
COMMA := ,
PLAIN := build$(if $(findstring clang,$(CC)),/clang)
B := $(PLAIN)$(if $(SAN),/san)

OPENEXR_CFLAGS := $(shell pkg-config --cflags OpenEXR 2>/dev/null || \
	echo -I/usr/include/OpenEXR -I/usr/include/Imath)
WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror \
	-Wno-format-truncation -Wno-unknown-warning-option # texts are cut on purpose
CFLAGS_ALL := -std=c17 -D_GNU_SOURCE $(OPT) -g -fno-math-errno \
	-ffp-contract=off $(WARN) -I. -I$(B)/gen \
	$(subst -I,-isystem ,$(OPENEXR_CFLAGS)) \
	$(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer -DGLINT_SANITIZED=1)
LDFLAGS_ALL := $(if $(SAN),-fsanitize=$(SAN)) -Wl,--as-needed
LIBS_D := -lEGL -lOpenEXRCore -lOpenEXR -lm -lpthread

GROUND := $(wildcard protocol/*.c)
CLIENT := $(wildcard protocol/client/*.c)
RENDERER := $(wildcard renderer/*.c)
SERVER := $(filter-out server/main.c,$(wildcard server/*.c))
objs = $(patsubst %.c,$(B)/obj/%.o,$(1))
LIB_OBJS := $(call objs,$(GROUND) $(RENDERER) $(SERVER))

# A C test is tests/{unit,numeric,render,fuzz,extremes}/test_NAME.c; helpers beside it
# that do not begin with test_ are linked into every test of that folder.
CTESTS := $(wildcard tests/unit/test_*.c tests/numeric/test_*.c \
	tests/render/test_*.c tests/fuzz/test_*.c tests/extremes/test_*.c)
CTEST_BINS := $(patsubst tests/%.c,$(B)/tests/%,$(CTESTS))
PYTESTS := $(wildcard tests/unit/test_*.py tests/numeric/test_*.py \
	tests/render/test_*.py tests/wire/test_*.py tests/browser/test_*.py)

.PHONY: all run test test-long deps deps-test floors format check-format clean
all: deps
	+@$(MAKE) --no-print-directory $(B)/glintd $(B)/glint

# --- dependencies -----------------------------------------------------------
# What a package provides is looked for first, so a machine that has it never
# calls the package manager.  Elsewhere than on Debian: say what is wanted.
DEBIAN_BUILD := gcc make pkg-config libegl-dev libgl-dev libopenexr-dev \
	libegl1 libegl-mesa0 libgl1-mesa-dri
DEBIAN_TEST := python3 nodejs npm chromium
HAVE_BUILD = command -v $(firstword $(CC)) && command -v pkg-config && \
	pkg-config --exists egl OpenEXR && test -e /usr/include/GL/glcorearb.h && \
	ls /usr/share/glvnd/egl_vendor.d/*.json
HAVE_TEST = command -v python3 && command -v node && command -v npm && \
	command -v chromium
# $(1) test, $(2) packages
define want
	@{ $(1); } >/dev/null 2>&1 || { \
	    root=; [ "$$(id -u)" = 0 ] || root=sudo; \
	    if command -v apt-get >/dev/null; then \
	        echo "installing: $(2)"; \
	        $$root apt-get update -qq && \
	        DEBIAN_FRONTEND=noninteractive $$root apt-get install -y -qq \
	            --no-install-recommends $(2) >/dev/null; \
	    else \
	        echo "This system has no apt-get.  Please install what Debian" \
	            "calls: $(2)" >&2; exit 1; \
	    fi; }
endef
deps:
	$(call want,$(HAVE_BUILD),$(DEBIAN_BUILD))
deps-test: deps
	$(call want,$(HAVE_TEST),$(DEBIAN_TEST))

# --- programs ---------------------------------------------------------------
Q := $(if $(V),,@)
say = $(if $(V),,@echo "$(1)")
$(B)/glintd: $(B)/obj/server/main.o $(LIB_OBJS)
	$(call say,LINK $@)
	$(Q)$(CC) $(LDFLAGS_ALL) -o $@ $^ $(LIBS_D)
$(B)/glint: $(call objs,$(CLIENT) $(GROUND))
	$(call say,LINK $@)
	$(Q)$(CC) $(LDFLAGS_ALL) -o $@ $^ -lm

$(B)/obj/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC $<)
	$(Q)$(CC) $(CFLAGS_ALL) -MMD -MP -c -o $@ $<

# Shaders and page are data: embedded, so the objects depend on them.
SHADERS := $(wildcard shaders/*)
$(B)/gen/shader_list.h: $(SHADERS) Makefile
	@mkdir -p $(@D)
	@for f in $(SHADERS); do n=$${f#shaders/}; \
	    echo "SHADER($$(echo $$n | tr . _), \"$$n\")"; done > $@
$(B)/obj/renderer/embed.o: $(SHADERS) $(B)/gen/shader_list.h
$(B)/obj/server/pages.o: $(wildcard web/*)
$(B)/obj/server/front_read.o: server/front.txt

BESIDE_EXTREMES := tests/numeric/cases.c tests/numeric/xu_double.c \
	tests/render/scene.c
$(B)/tests/extremes/%: BESIDE = $(BESIDE_EXTREMES)
$(B)/tests/extremes/test_extremes $(B)/tests/extremes/bench_extremes: \
	$(wildcard tests/extremes/*.[ch]) $(BESIDE_EXTREMES)
$(B)/tests/render/test_large: BESIDE = tests/bench/grown.c
$(B)/tests/render/test_large: tests/bench/grown.c
$(B)/tests/%: tests/%.c $(LIB_OBJS)
	@mkdir -p $(@D)
	$(call say,CC $<)
	$(Q)$(CC) $(CFLAGS_ALL) -MMD -MP -MF $@.d $(LDFLAGS_ALL) -o $@ $< \
	    $(filter-out $(wildcard $(dir $<)test_*.c $(dir $<)bench_*.c), \
	        $(wildcard $(dir $<)*.c)) $(BESIDE) \
	    $(LIB_OBJS) $(LIBS_D)

-include $(shell find $(B) -name '*.d' 2>/dev/null)

# --- running and testing ----------------------------------------------------
run: all
	$(B)/glintd serve --hair builtin:animation --env builtin:studio $(ARGS)

TEST_ENV = GLINTD=$(CURDIR)/$(B)/glintd GLINT=$(CURDIR)/$(B)/glint \
	GLINT_SAN=$(SAN) GLINT_PLAIN=$(CURDIR)/$(PLAIN) \
	ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 \
	LSAN_OPTIONS=suppressions=$(CURDIR)/tests/lsan.supp:print_suppressions=0 \
	UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
test: deps-test
	+@$(MAKE) --no-print-directory -j2 tests-built
	$(if $(SAN),+@$(MAKE) --no-print-directory -j2 SAN= \
	    $(PLAIN)/glintd $(PLAIN)/glint)
	@$(TEST_ENV) python3 tests/run.py $(CTEST_BINS) $(PYTESTS)
test-long: export GLINT_LONG = 1
test-long: test
# As others see it: sanitizers take half an hour, another compiler as long as ours.
test-san:
	+@$(MAKE) --no-print-directory SAN=$(or $(SAN),address$(COMMA)undefined) test
test-clang:
	+@$(MAKE) --no-print-directory CC=clang test
.PHONY: tests-built test-san test-clang
tests-built: floors $(B)/glintd $(B)/glint $(CTEST_BINS)

# Timings; not part of the tests.  make bench-stages ARGS="animation straight"
BENCHES := $(patsubst tests/bench/%.c,$(B)/tests/bench/%,\
	$(wildcard tests/bench/bench_*.c))
.PHONY: bench bench-stages bench-drafts bench-shadows bench-forward bench-encode
# Error against run time: the committed report, from scratch (references that
# were made before are found again).  ARGS=--quick: two minutes, into build/.
GLINT_DATA ?= ../shared/data
BENCH_TO := $(if $(findstring --quick,$(ARGS)),$(B),docs)
BENCH_DAWN := $(GLINT_DATA)/hair/straight.hair@$(GLINT_DATA)/env/pmndrs_dawn.exr
BENCH_VENICE := $(GLINT_DATA)/hair/amd_ruby_long.hair@$(GLINT_DATA)/env/venice_sunset_1k.hdr
BENCH_SCENES := ponytail,animation,bob,dark,straight,natural$(if \
	$(wildcard $(GLINT_DATA)/hair/straight.hair),$(COMMA)$(BENCH_DAWN)$(COMMA)$(BENCH_VENICE))
bench: all
	@mkdir -p $(BENCH_TO)/pictures
	$(B)/glintd bench --command "make bench" --report $(BENCH_TO)/BENCH.md \
	    --plot $(BENCH_TO)/pictures/bench.svg \
	    $(if $(findstring --quick,$(ARGS)),,--scenes $(BENCH_SCENES)) \
	    $(ARGS) > $(B)/bench.jsonl
# What a governor chooses among, measured anew: server/front.txt, which ships with
# the program.  Minutes a scene: ponytail takes 130 s of processor time.
.PHONY: front
front: all
	$(B)/glintd bench --front server/front.txt $(ARGS) > $(B)/front.jsonl
# What an edit costs, kind by kind, beside paper-forward: docs/EDITS.md, its plot
# and the README's table.  ARGS=--quick: into build/, README untouched.
.PHONY: bench-edits
BENCH_CURLY := $(GLINT_DATA)/hair/amd_ponytail.hair
BENCH_EDITS := animation,straight,natural,ponytail,bob,dark$(if \
	$(wildcard $(BENCH_CURLY)),$(COMMA)$(BENCH_CURLY))
bench-edits: all
	@mkdir -p $(BENCH_TO)/pictures
	$(B)/glintd bench --edits --command "make bench-edits" \
	    --report $(BENCH_TO)/EDITS.md --plot $(BENCH_TO)/pictures/edits.svg \
	    $(if $(findstring --quick,$(ARGS)),,--scenes $(BENCH_EDITS)) \
	    $(ARGS) > $(B)/edits.jsonl
	$(if $(findstring --quick,$(ARGS)),,@python3 tests/bench/readme_edits.py)
# How that grows with places, lights, strands, points and pixels: docs/SCALE.md.
# ARGS=--quick: fewer of each, into build/.
.PHONY: bench-scale
bench-scale: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_scale
	@mkdir -p $(BENCH_TO)/pictures
	@$(B)/tests/bench/bench_scale --report $(BENCH_TO)/SCALE.md \
	    --pictures $(BENCH_TO)/pictures $(ARGS) > $(B)/scale.jsonl
bench-stages: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_stages
	@$(B)/tests/bench/bench_stages $(ARGS)
# Drags: drafts and the full frames that they stand for.
bench-drafts: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_drafts
	@$(B)/tests/bench/bench_drafts $(ARGS)
# Writes docs/SHADOWS.md; a few minutes on two quiet cores.
bench-shadows: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_crossings
	@GLINT_DATA=$(GLINT_DATA) $(B)/tests/bench/bench_crossings $(ARGS) \
	    > $(B)/shadows.jsonl
	@python3 tests/bench/shadows_report.py < $(B)/shadows.jsonl \
	    > docs/SHADOWS.md
bench-forward: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_forward
	@$(B)/tests/bench/bench_forward $(ARGS)
bench-encode: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_encode
	@$(B)/tests/bench/bench_encode $(ARGS)

# Stiff and extreme cases at length: makes docs/EXTREMES.md from scratch, fails
# when a law is broken.
.PHONY: extremes
extremes: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/extremes/bench_extremes
	@$(B)/tests/extremes/bench_extremes $(B)/EXTREMES.md && \
	    mv $(B)/EXTREMES.md docs/EXTREMES.md

# Four colours of hair, lit from the front and from behind, for eyes to judge;
# a few minutes.  make sheet ARGS="--groom natural --samples 64"
.PHONY: sheet
sheet: deps
	+@$(MAKE) --no-print-directory -s $(B)/tests/bench/bench_sheet
	@$(B)/tests/bench/bench_sheet $(ARGS) docs/pictures/sheet.jpg

# Pages of the docs that the programs write themselves.
.PHONY: docs
docs: all
	@{ printf '# Parameters\n\nMade by `make docs` from protocol/params.def. '; \
	    printf 'Set one with `glint set GROUP.NAME=VALUE`.\n\n'; \
	    $(B)/glint get --markdown; } > docs/PARAMETERS.md

# --- house rules ------------------------------------------------------------
# Includes point down only: tests -> server -> renderer -> protocol.
floors:
	@! grep -nE '#include "(renderer|server|tests)/' protocol/*.[ch] \
	    protocol/client/*.[ch] 2>/dev/null
	@! grep -nE '#include "(server|tests)/' renderer/*.[ch]
	@! grep -nE '#include "tests/' server/*.[ch]
# Programs go back to their pool (program_pool.h).
	@! grep -nE 'gl\.DeleteProgram' $(filter-out renderer/program%,\
	    $(wildcard renderer/*.c server/*.c))
FORMATTED = $(wildcard */*.[ch] */*/*.[ch])
format:
	clang-format -i $(FORMATTED)
check-format:
	clang-format --dry-run -Werror $(FORMATTED)
clean:
	rm -rf build
