#pragma once

#include <cvode/cvode.h>

#include <string>

#include "solvers/error.hpp"

// Functions whose names differ between SUNDIALS 6 and 7.
namespace lichtenberg::sundials {

/// Makes a context without MPI, which the caller frees; warnings are not printed. Throws Failure.
inline SUNContext make_context() {
#if SUNDIALS_VERSION_MAJOR >= 7
  const SUNComm no_processes = SUN_COMM_NULL;
#else
  constexpr void* no_processes = nullptr;
#endif
  SUNContext context = nullptr;
  if (SUNContext_Create(no_processes, &context) != 0) throw Failure("SUNDIALS could not be started");
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_SetLogger(context, nullptr);  // it prints warnings; no error handler of this version receives them
#endif
  return context;
}

/// Lets the integrator `cvode` of this context store the last of its messages in `message`, which must exist as long as
/// the integrator, and not print them. Returns CVODE's flag.
inline int keep_messages(SUNContext context, void* cvode, std::string& message) {
#if SUNDIALS_VERSION_MAJOR >= 7
  (void)cvode;
  SUNContext_ClearErrHandlers(context);
  return SUNContext_PushErrHandler(
      context,
      [](int, const char*, const char*, const char* text, SUNErrCode, void* kept, SUNContext) {
        *static_cast<std::string*>(kept) = text ? text : "";
      },
      &message);
#else
  (void)context;
  return CVodeSetErrHandlerFn(
      cvode, [](int, const char*, const char*, char* text, void* kept) { *static_cast<std::string*>(kept) = text; },
      &message);
#endif
}

}  // namespace lichtenberg::sundials
