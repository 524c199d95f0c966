# One test program per module of core, named after it.
CORE_TESTS = \
	tests/core/test_branches \
	tests/core/test_cache \
	tests/core/test_compliance \
	tests/core/test_contact \
	tests/core/test_cost \
	tests/core/test_dynamics \
	tests/core/test_deck \
	tests/core/test_field \
	tests/core/test_force \
	tests/core/test_elasticity \
	tests/core/test_front \
	tests/core/test_gear \
	tests/core/test_grid \
	tests/core/test_macro \
	tests/core/test_iso6336 \
	tests/core/test_memory \
	tests/core/test_mesh \
	tests/core/test_multistart \
	tests/core/test_orbit \
	tests/core/test_pair \
	tests/core/test_pool \
	tests/core/test_profile \
	tests/core/test_random \
	tests/core/test_reliability \
	tests/core/test_relief \
	tests/core/test_search \
	tests/core/test_sequence \
	tests/core/test_statics \
	tests/core/test_stress \
	tests/core/test_study \
	tests/core/test_study_macro
TEST_LIBS = $(CORE_LIBS) $(CMOCKA_LIBS)

if HAVE_CMOCKA
check_PROGRAMS += $(CORE_TESTS)
TESTS += $(CORE_TESTS)
endif

tests_core_test_branches_SOURCES = tests/core/test_branches.c tests/core/oscillators.h
tests_core_test_branches_LDADD = $(TEST_LIBS)

tests_core_test_cache_SOURCES = tests/core/test_cache.c tests/core/cases.h
tests_core_test_cache_LDADD = $(TEST_LIBS)
tests_core_test_cost_SOURCES = tests/core/test_cost.c
tests_core_test_cost_LDADD = $(TEST_LIBS)

tests_core_test_study_SOURCES = tests/core/test_study.c tests/core/cases.h
tests_core_test_study_LDADD = $(TEST_LIBS)

tests_core_test_study_macro_SOURCES = tests/core/test_study_macro.c tests/core/cases.h
tests_core_test_study_macro_LDADD = $(TEST_LIBS)

tests_core_test_compliance_SOURCES = tests/core/test_compliance.c tests/core/cases.h
tests_core_test_compliance_LDADD = $(TEST_LIBS)

tests_core_test_contact_SOURCES = tests/core/test_contact.c tests/core/cases.h
tests_core_test_contact_LDADD = $(TEST_LIBS)

tests_core_test_dynamics_SOURCES = tests/core/test_dynamics.c tests/core/oscillators.h
tests_core_test_dynamics_LDADD = $(TEST_LIBS)

tests_core_test_elasticity_SOURCES = tests/core/test_elasticity.c tests/core/cases.h
tests_core_test_elasticity_LDADD = $(TEST_LIBS)

tests_core_test_deck_SOURCES = tests/core/test_deck.c tests/core/cases.h
tests_core_test_deck_LDADD = $(TEST_LIBS)

tests_core_test_field_SOURCES = tests/core/test_field.c tests/core/cases.h
tests_core_test_field_LDADD = $(TEST_LIBS)

tests_core_test_gear_SOURCES = tests/core/test_gear.c tests/core/cases.h
tests_core_test_gear_LDADD = $(TEST_LIBS)

tests_core_test_grid_SOURCES = tests/core/test_grid.c tests/core/cases.h
tests_core_test_grid_LDADD = $(TEST_LIBS)

tests_core_test_iso6336_SOURCES = tests/core/test_iso6336.c tests/core/cases.h
tests_core_test_iso6336_LDADD = $(TEST_LIBS)

tests_core_test_macro_SOURCES = tests/core/test_macro.c tests/core/cases.h
tests_core_test_macro_LDADD = $(TEST_LIBS)

tests_core_test_memory_SOURCES = tests/core/test_memory.c tests/core/cases.h
tests_core_test_memory_LDADD = $(TEST_LIBS)

tests_core_test_mesh_SOURCES = tests/core/test_mesh.c tests/core/cases.h
tests_core_test_mesh_LDADD = $(TEST_LIBS)

tests_core_test_orbit_SOURCES = tests/core/test_orbit.c tests/core/oscillators.h
tests_core_test_orbit_LDADD = $(TEST_LIBS)

tests_core_test_pair_SOURCES = tests/core/test_pair.c tests/core/cases.h
tests_core_test_pair_LDADD = $(TEST_LIBS)

tests_core_test_force_SOURCES = tests/core/test_force.c tests/core/cases.h
tests_core_test_force_LDADD = $(TEST_LIBS)

tests_core_test_pool_SOURCES = tests/core/test_pool.c
tests_core_test_pool_LDADD = $(TEST_LIBS)

tests_core_test_profile_SOURCES = tests/core/test_profile.c tests/core/cases.h
tests_core_test_profile_LDADD = $(TEST_LIBS)

tests_core_test_random_SOURCES = tests/core/test_random.c tests/core/cases.h
tests_core_test_random_LDADD = $(TEST_LIBS)

tests_core_test_reliability_SOURCES = tests/core/test_reliability.c
tests_core_test_reliability_LDADD = $(TEST_LIBS)

tests_core_test_relief_SOURCES = tests/core/test_relief.c tests/core/cases.h
tests_core_test_relief_LDADD = $(TEST_LIBS)

tests_core_test_search_SOURCES = tests/core/test_search.c tests/core/cases.h
tests_core_test_search_LDADD = $(TEST_LIBS)

tests_core_test_stress_SOURCES = tests/core/test_stress.c tests/core/cases.h
tests_core_test_stress_LDADD = $(TEST_LIBS)

tests_core_test_front_SOURCES = tests/core/test_front.c tests/core/cases.h
tests_core_test_front_LDADD = $(TEST_LIBS)

tests_core_test_multistart_SOURCES = tests/core/test_multistart.c tests/core/cases.h
tests_core_test_multistart_LDADD = $(TEST_LIBS)

tests_core_test_sequence_SOURCES = tests/core/test_sequence.c tests/core/cases.h
tests_core_test_sequence_LDADD = $(TEST_LIBS)

tests_core_test_statics_SOURCES = tests/core/test_statics.c tests/core/cases.h tests/core/reference_S.h
tests_core_test_statics_LDADD = $(TEST_LIBS)

# The whole comparison with CVODE: 360 speeds, some 20 s.
.PHONY: check-long
check-long: tests/core/test_dynamics
	QG_LONG_TESTS=1 CMOCKA_MESSAGE_OUTPUT=TAP tests/core/test_dynamics

# Whether the branches found by continuation contain what marching reaches from 48 000 random states; some 10 s.
EXTRA_PROGRAMS += tests/core/check_branches
tests_core_check_branches_SOURCES = tests/core/check_branches.c tests/core/oscillators.h
tests_core_check_branches_LDADD = $(CORE_LIBS)
CLEANFILES += tests/core/check_branches
.PHONY: check-branches
check-branches: tests/core/check_branches
	tests/core/check_branches
