MODULE Options
    ! Options: what RobotWare knows, never run.
    VAR robtarget p;
    PERS seamdata sm:=[0,[1,2]];
    PERS welddata wd:=[5,[1,2,3]];
    PERS weavedata wv;
    PERS gundata g;
    PERS spotdata s;
    PERS beaddata bd:=[1];
    VAR egmident e;
    CONST pose po:=[[0,0,0],[1,0,0,0]];
    CONST egm_minmax mm:=[-1,1];
    VAR cameradev cam;
    VAR cameratarget ct;
    VAR intnum i;

    PROC main()
        ArcLStart p,v100,sm,wd\Weave:=wv,fine,tool0\SeamName:="s";
        ArcL\On,p,v100,sm,wd,wv,z1,tool0;
        SpotL p,vmax,g,s,tool0;
        DispL\On,p,v100,bd,z30,tool0;
        EGMActPose e\StreamStart\Tool:=tool0,po,EGM_FRAME_WOBJ,po,EGM_FRAME_BASE\x:=mm\LpFilter:=2\SampleRate:=4;
        EGMRunPose e,EGM_STOP_HOLD\x\y\CondTime:=1\RampInTime:=0.1;
        CSSAct\RefFrame:=1,2;
        FCAct tool0;
        CamReqImage cam\AwaitComplete;
        CamGetResult cam,ct\MaxTime:=2;
        ICap i,CAP_STOP;
    ENDPROC
ENDMODULE
