// SPDX-License-Identifier: GPL-3.0-or-later
/// What Ceres' solvers of linear systems call, for a program that calls none of them.
///
/// The fits minimise by line search (ceres::GradientProblemSolver). The static libceres brings all other solvers with
/// it all the same, and with them CHOLMOD, CXSparse, LAPACK, ATLAS, and the run-time libraries of Fortran and OpenMP:
/// 17 shared libraries whose loading was a third of the time that the program takes to start. With these definitions
/// the linker needs none of them (--as-needed). A function that is missing here, in another version of Ceres, is
/// taken from its library as before: the program starts later, and nothing else.
#include <cstdio>
#include <cstdlib>

namespace {

[[noreturn]] void stop(const char* function) {
  std::fprintf(stderr, "bouncelab: %s was called, which no part of the program needs (tools/bouncelab/%s)\n", function,
               "unused_solvers.cpp");
  std::abort();
}

}  // namespace

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): as many functions of the same kind
#define BOUNCELAB_UNUSED(function) \
  extern "C" void function();      \
  extern "C" void function() { stop(#function); }

BOUNCELAB_UNUSED(cholmod_amd)
BOUNCELAB_UNUSED(cholmod_analyze)
BOUNCELAB_UNUSED(cholmod_analyze_p)
BOUNCELAB_UNUSED(cholmod_camd)
BOUNCELAB_UNUSED(cholmod_factorize)
BOUNCELAB_UNUSED(cholmod_finish)
BOUNCELAB_UNUSED(cholmod_free_dense)
BOUNCELAB_UNUSED(cholmod_free_factor)
BOUNCELAB_UNUSED(cholmod_free_sparse)
BOUNCELAB_UNUSED(cholmod_print_common)
BOUNCELAB_UNUSED(cholmod_solve)
BOUNCELAB_UNUSED(cholmod_start)
BOUNCELAB_UNUSED(cholmod_triplet_to_sparse)
BOUNCELAB_UNUSED(cholmod_zeros)
BOUNCELAB_UNUSED(cs_di_amd)
BOUNCELAB_UNUSED(cs_di_calloc)
BOUNCELAB_UNUSED(cs_di_chol)
BOUNCELAB_UNUSED(cs_di_cholsol)
BOUNCELAB_UNUSED(cs_di_compress)
BOUNCELAB_UNUSED(cs_di_counts)
BOUNCELAB_UNUSED(cs_di_cumsum)
BOUNCELAB_UNUSED(cs_di_etree)
BOUNCELAB_UNUSED(cs_di_free)
BOUNCELAB_UNUSED(cs_di_ipvec)
BOUNCELAB_UNUSED(cs_di_lsolve)
BOUNCELAB_UNUSED(cs_di_ltsolve)
BOUNCELAB_UNUSED(cs_di_malloc)
BOUNCELAB_UNUSED(cs_di_multiply)
BOUNCELAB_UNUSED(cs_di_nfree)
BOUNCELAB_UNUSED(cs_di_pinv)
BOUNCELAB_UNUSED(cs_di_post)
BOUNCELAB_UNUSED(cs_di_pvec)
BOUNCELAB_UNUSED(cs_di_schol)
BOUNCELAB_UNUSED(cs_di_sfree)
BOUNCELAB_UNUSED(cs_di_spfree)
BOUNCELAB_UNUSED(cs_di_symperm)
BOUNCELAB_UNUSED(cs_di_transpose)
BOUNCELAB_UNUSED(dgeqrf_)
BOUNCELAB_UNUSED(dormqr_)
BOUNCELAB_UNUSED(dpotrf_)
BOUNCELAB_UNUSED(dpotrs_)
BOUNCELAB_UNUSED(dtrtrs_)
