# schema: the language. The only place that knows both JSON and core's structs.
noinst_LIBRARIES += libschema.a
libschema_a_SOURCES = \
	schema/abaqus.c schema/abaqus.h \
	schema/document.h \
	schema/drawing.h \
	schema/dxf.c \
	schema/field.c schema/field_files.c schema/field.h \
	schema/faults.c schema/faults.h \
	schema/fields.c schema/fields.h \
	schema/members.h \
	schema/profile.c \
	schema/read.c schema/read.h \
	schema/read_bytes.c \
	schema/result.c schema/result.h schema/result_internal.h \
	schema/result_design.c \
	schema/result_macro.c \
	schema/result_series.c \
	schema/scan.c schema/scan.h \
	schema/stress_result.c schema/stress_result.h \
	schema/text.c schema/text.h \
	schema/words.c schema/words.h \
	schema/write.c
libschema_a_CPPFLAGS = $(AM_CPPFLAGS) $(CJSON_CFLAGS)
SCHEMA_LIBS = libschema.a $(CORE_LIBS) $(CJSON_LIBS)

schemadir = $(pkgdatadir)/schema
dist_schema_DATA = \
	schema/audit-entry.schema.json \
	schema/delivery.schema.json \
	schema/evaluation.schema.json \
	schema/field.schema.json \
	schema/frequency-response.schema.json \
	schema/job.schema.json \
	schema/openapi.json \
	schema/profile.schema.json \
	schema/result.schema.json \
	schema/token-request.schema.json \
	schema/token.schema.json \
	schema/webhook-message.schema.json \
	schema/webhook-request.schema.json \
	schema/webhook.schema.json
exampledir = $(schemadir)/examples
dist_example_DATA = \
	schema/examples/case_B_branches.json \
	schema/examples/case_B_load_dependent.json \
	schema/examples/case_H_optimize.json \
	schema/examples/case_H_optimize_8.json \
	schema/examples/case_H_optimize_8_multistart.json \
	schema/examples/case_H_stresses.json \
	schema/examples/case_S_branches.json \
	schema/examples/case_S_clamped.json \
	schema/examples/case_S_macro.json \
	schema/examples/case_S_map_amplitudes.json \
	schema/examples/case_S_map_radii.json \
	schema/examples/case_S_none.json \
	schema/examples/case_S_optimize.json \
	schema/examples/case_S_optimize_parabolic.json \
	schema/examples/case_S_optimize_parabolic_f_pps.json \
	schema/examples/case_S_pareto.json \
	schema/examples/case_S_reliability.json \
	schema/examples/case_S_robust.json \
	schema/examples/case_S_standard.json
