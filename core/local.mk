# core: the engineering. Structs in, structs out.
noinst_LIBRARIES += libcore.a
libcore_a_SOURCES = \
	core/status.c core/status.h \
	core/gear.c core/gear.h \
	core/pair.c core/pair.h \
	core/iso6336.c core/iso6336.h \
	core/relief.c core/relief.h \
	core/mesh.c core/mesh.h \
	core/gear_mesh.c core/gear_mesh.h \
	core/deck.c core/deck.h \
	core/field.c core/field.h \
	core/field_view.c core/field_view.h \
	core/elasticity.c core/elasticity.h \
	core/compliance.c core/compliance.h \
	core/cache.c core/cache.h \
	core/cost.c core/cost.h \
	core/memory.c core/memory.h \
	core/design_copy.c core/design_copy.h \
	core/contact.c core/contact.h \
	core/nodal.c core/nodal.h \
	core/stress.c core/stress.h \
	core/statics.c core/statics.h \
	core/model.c core/model.h \
	core/random.c core/random.h \
	core/reliability.c core/reliability.h \
	core/search.c core/search.h \
	core/sequence.c core/sequence.h \
	core/multistart.c core/multistart.h \
	core/front.c core/front.h \
	core/grid.c core/grid.h \
	core/macro.c core/macro.h \
	core/macro_keep.c core/macro_keep.h \
	core/macro_sample.c core/macro_sample.h core/macro_teeth.h \
	core/macro_teeth_baseline.c core/macro_teeth_avx2.c core/macro_teeth_avx512.c core/macro_teeth_kernel.h \
	core/study.c core/study.h core/study_internal.h \
	core/study_check.c \
	core/study_gate.c \
	core/study_macro.c \
	core/study_search.c \
	core/study_verify.c \
	core/study_warnings.c \
	core/biarc.c core/biarc.h \
	core/profile.c core/profile.h \
	core/dynamics.c core/dynamics.h \
	core/dynamics_batch.c core/dynamics_batch.h \
	core/dynamics_baseline.c core/dynamics_avx2.c core/dynamics_avx512.c core/dynamics_kernel.h core/force_kernel.h \
	core/dynamics_steady.c core/dynamics_steady.h \
	core/force.c core/force.h \
	core/dynamics_reference.c \
	core/orbit.c core/orbit.h \
	core/attractors.c core/attractors.h \
	core/continuation.c core/continuation.h \
	core/branches.c core/branches.h \
	core/executor.c core/executor.h \
	core/pool.c core/pool.h
CORE_LIBS = libcore.a $(SUITESPARSE_LIBS) $(SUNDIALS_LIBS) $(LAPACKE_LIBS) $(OPENBLAS_LIBS) -lgomp -lm
