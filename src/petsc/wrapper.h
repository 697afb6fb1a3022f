// Headers of PETSc and METIS, and the allow-list that build.rs hands to bindgen.
#include <petscsnes.h>
#include <metis.h>
// bind variables: PETSC_COMM_WORLD PETSC_DEFAULT PetscTrFree PETSC_ERR_.* PETSC_VERSION_.* METIS_OPTION_.* METIS_NOPTIONS METIS_OK
// bind types: PetscInt PetscReal PetscScalar PetscBool PetscErrorCode PetscErrorType InsertMode MatAssemblyType MatOption MatOperation NormType ScatterMode SNESConvergedReason KSPConvergedReason PCFailedReason KSPNormType MatInfo MatInfoType PetscCopyMode idx_t real_t moptions_et rstatus_et
// bind functions: PetscInitialize PetscFinalize PetscPushErrorHandler PetscPopErrorHandler PetscErrorMessage PetscGetVersionNumber
// bind functions: PetscOptionsInsertString PetscOptionsSetValue PetscOptionsClearValue PetscOptionsInsertArgs PetscOptionsGetAll PetscOptionsLeftGet PetscOptionsLeftRestore
// bind functions: PetscLogStageRegister PetscLogStagePush PetscLogStagePop
// bind functions: VecCreateMPI VecDuplicate VecDestroy VecSetBlockSize VecGetLocalSize VecGetArray VecRestoreArray VecGetArrayRead VecRestoreArrayRead VecNorm VecSet VecCopy
// bind functions: MatCreate MatDestroy MatSetSizes MatSetType MatSetBlockSize MatSetOption MatSeqAIJSetPreallocation MatMPIAIJSetPreallocation
// bind functions: MatSetValuesBlocked MatSetValues MatAssemblyBegin MatAssemblyEnd MatZeroEntries MatMult MatGetInfo MatZeroRows
// bind functions: MatSetNearNullSpace MatNullSpaceCreateRigidBody MatNullSpaceDestroy MatMumpsGetInfog
// bind functions: KSPGetPC KSPGetIterationNumber KSPGetConvergedReason KSPSetTolerances KSPReset KSPGetResidualNorm KSPGetType
// bind functions: PCFactorGetMatrix PCFactorGetMatSolverType PCGetType PCGetFailedReason
// bind functions: SNESCreate SNESDestroy SNESSetType SNESSetLagPreconditioner SNESSetFunction SNESSetJacobian SNESSetFromOptions SNESSetOptionsPrefix SNESSolve SNESGetKSP SNESGetConvergedReason SNESGetIterationNumber SNESGetLinearSolveIterations SNESSetConvergenceTest SNESSetTolerances SNESGetLineSearch SNESLineSearchSetPreCheck SNESLineSearchSetType SNESGetFunction SNESGetSolution
// bind functions: MatCreateShell MatShellSetOperation MatShellGetContext PCSetType PCMGSetLevels PCMGSetInterpolation PCMGGetSmoother PCMGGetLevels KSPSetOperators KSPSetType KSPChebyshevSetEigenvalues KSPSetConvergenceTest KSPGetTolerances KSPBuildSolution KSPDestroy PetscObjectReference
// bind functions: PCShellSetContext PCShellGetContext PCShellSetApply PCShellSetDestroy
// bind functions: METIS_MeshToDual METIS_PartGraphKway METIS_PartGraphRecursive METIS_SetDefaultOptions METIS_Free
// bind functions: KSPSetPreSolve KSPSetInitialGuessNonzero KSPSolve KSPConvergedDefault KSPConvergedDefaultCreate KSPConvergedDefaultDestroy KSPSetUp KSPSetReusePreconditioner PCApply
